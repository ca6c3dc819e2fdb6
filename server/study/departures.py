"""Leaving a study before its end: the code, the partner who is left behind, and the deletion of data."""

import asyncio
from pathlib import Path

from movingout.server.notices import Notice
from movingout.server.public_host import PublicHost
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.participants import Participants
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.data.erasure import remove_recordings
from movingout.study.design.definition import Outcome
from movingout.study.errors import StudyError
from movingout.study.store.removal import episodes_of, has_data, withdraw_data

PARTICIPANT_LEFT = Notice("participant_left", "The round was ended, because somebody left the study.")


class Departures:
    """Ends the study for participants, and deletes the data of those who ask for it."""

    def __init__(
        self,
        recordings: Path,
        host: PublicHost,
        databases: StudyDatabases,
        alerts: Alerts,
        participants: Participants,
        units: Units,
        rooms: StudyRooms,
    ) -> None:
        self._recordings = recordings
        self._host = host
        self._databases = databases
        self._alerts = alerts
        self._participants = participants
        self._units = units
        self._rooms = rooms
        self._deletions: set[asyncio.Task[None]] = set()

    async def dismiss(self, tx: Transaction, session: ParticipantSession, outcome: Outcome, keep: bool = True) -> None:
        """End the study for one participant, with a code; a partner who cannot play on gets one as well."""
        tx.check()
        if session.finished:
            return
        if not keep:
            await tx.run(self._databases.store.keep_data, session.pid, False)
        await self._participants.finish(tx, session, outcome)
        self._units.stop_waiting(tx, session)
        notify([session])
        unit = self._units.of(session)
        if unit is not None:
            await self.release_partners(tx, unit)
        if not keep:
            self.delete_data(session)

    async def release_partners(self, tx: Transaction, unit: StudyUnit) -> None:
        """Somebody of the unit has left: finish those whose remaining rounds cannot be played."""
        await self._rooms.close(tx, unit, PARTICIPANT_LEFT, "left")
        for session in unit.members:
            if not session.finished and session.has_rounds_left():
                await self._participants.finish(tx, session, "partner-left")
                notify([session])

    def delete_data(self, session: ParticipantSession) -> None:
        """In the background; after a kill it is done at the next start."""
        task = asyncio.create_task(self._delete(session.pid))
        self._deletions.add(task)
        task.add_done_callback(self._deletions.discard)

    async def _delete(self, pid: str) -> None:
        """Delete answers and recordings once the last recording is on the disk. The code stays, for the payment."""
        await self._rooms.finished.saved()
        await self._host.recording_service.settled()
        store, run = self._databases.store, self._databases.run
        try:
            if await run(has_data, store, pid):
                episodes = set(await run(episodes_of, store, pid))
                removed = await asyncio.to_thread(remove_recordings, self._recordings, pid, episodes)
                await run(withdraw_data, store, pid, removed)
        except StudyError as error:
            self._alerts.add("deletion", f"The data of {pid} could not be deleted.", str(error), pid=pid)

    async def deleted(self) -> None:
        """Wait until every deletion that has begun is done."""
        await asyncio.gather(*self._deletions, return_exceptions=True)
