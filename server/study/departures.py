"""Leaving a study before its end: the code, and the partner who is left behind."""

from collections.abc import Callable

from movingout.server.notices import Notice
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.deletions import Deletions
from movingout.server.study.notes import ExperimenterNotes
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.participants import Participants
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.design.definition import Outcome

PARTICIPANT_LEFT = Notice("participant_left", "The round was ended, because somebody left the study.")


class Departures:
    """Ends the study for participants, and has the data of those deleted who ask for it."""

    def __init__(
        self,
        databases: StudyDatabases,
        participants: Participants,
        units: Units,
        rooms: StudyRooms,
        deletions: Deletions,
        notes: ExperimenterNotes,
        is_paused: Callable[[ParticipantSession], bool],
    ) -> None:
        self._databases = databases
        self._participants = participants
        self._units = units
        self._rooms = rooms
        self._deletions = deletions
        self._notes = notes
        self._is_paused = is_paused

    async def dismiss(
        self, tx: Transaction, session: ParticipantSession, outcome: Outcome, keep: bool | None = None
    ) -> None:
        """End the study for one participant, with a code; a partner who cannot play on gets one as well.

        Who has not consented gets none, and nothing about them is kept: they have declined. `keep`: what the
        participant said about the data, None where nobody asked.
        """
        tx.check()
        if session.finished:
            await self._note_late_wish(tx, session, keep)
            return
        if not session.has_consented:
            await self.decline(tx, session)
            return
        if keep is not None:
            await tx.run(self._databases.store.keep_data, session.pid, keep)
        await self._participants.finish(tx, session, outcome, paused=self._is_paused(session))
        self._units.stop_waiting(tx, session)
        notify([session])
        unit = self._units.of(session)
        try:
            if unit is not None:
                await self.release_partners(tx, unit)
        finally:  # the machine of their room may be away
            if keep is False:
                self.delete_data(session)

    async def decline(self, tx: Transaction, session: ParticipantSession) -> None:
        """No consent: nothing about them is kept, nor what was noted about them."""
        await self._participants.decline(tx, session)
        self._notes.forget([session.pid])
        notify([session])

    async def _note_late_wish(self, tx: Transaction, session: ParticipantSession, keep: bool | None) -> None:
        """Of two who stop at the same time, the second has a code by the time they ask for the deletion."""
        if keep is None or session.declined or session.record.keep is not None:
            return
        await tx.run(self._databases.store.keep_data, session.pid, keep)
        await self._participants.refresh(tx, session)
        notify([session])
        if not keep:
            self.delete_data(session)

    async def release_partners(self, tx: Transaction, unit: StudyUnit) -> None:
        """Somebody of the unit has left: finish those whose remaining rounds cannot be played."""
        await self._rooms.close(tx, unit, PARTICIPANT_LEFT, "left")
        for session in await self._units.with_rounds_left(tx, unit):
            await self._participants.finish(tx, session, "partner-left", paused=self._is_paused(session))
            notify([session])

    def delete_data(self, session: ParticipantSession) -> None:
        """In the background."""
        self._deletions.add(session.pid)
