"""Leaving a study before its end: the code, the partner who is left behind, and the deletion of data."""

import asyncio
import contextlib
import time
from collections.abc import Callable, Coroutine, Iterable
from pathlib import Path
from typing import Any

from movingout.server.notices import Notice
from movingout.server.public_host import PublicHost
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.notes import ExperimenterNotes
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.participants import Participants
from movingout.server.study.rounds.round_recovery import FINISHED_S
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.data.erasure import is_being_recorded, named_in_recordings, remove_recordings
from movingout.study.design.definition import Outcome
from movingout.study.store.removal import episodes_of, has_data, withdraw_data
from movingout.study.store.tables import rounds

LOOK_S = 0.5  # between two looks whether a recording is finished
LOOK_AGAIN_S = (10.0, 60.0, 600.0)  # after a deletion; the last one again and again while it fails
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
        notes: ExperimenterNotes,
        is_paused: Callable[[ParticipantSession], bool],
    ) -> None:
        self._recordings = recordings
        self._host = host
        self._databases = databases
        self._alerts = alerts
        self._participants = participants
        self._units = units
        self._rooms = rooms
        self._notes = notes
        self._is_paused = is_paused
        self._deletions: set[asyncio.Task[None]] = set()
        self._ending = asyncio.Event()

    async def dismiss(
        self, tx: Transaction, session: ParticipantSession, outcome: Outcome, keep: bool | None = None
    ) -> None:
        """End the study for one participant, with a code; a partner who cannot play on gets one as well.

        `keep`: what the participant said about the data, None where nobody asked.
        """
        tx.check()
        if session.finished:
            await self._note_late_wish(tx, session, keep)
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
        """In the background; after a kill it is done at the next start."""
        self._begin(self._delete(session.pid))

    def delete_again(self, sessions: Iterable[ParticipantSession]) -> None:
        """At a start: what is still there, or came since, of those who asked for the deletion."""
        self._begin(self._delete_rest([session.pid for session in sessions]))

    def _begin(self, deletion: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(deletion)
        self._deletions.add(task)
        task.add_done_callback(self._deletions.discard)

    async def _delete_rest(self, pids: list[str]) -> None:
        run, store = self._databases.run, self._databases.store
        try:
            named = await asyncio.to_thread(named_in_recordings, self._recordings, pids)
            left = [pid for pid in pids if pid in named or await run(has_data, store, pid)]
        except Exception:  # noqa: BLE001 - of any kind: whoever asked for it is tried, one by one
            left = pids
        for pid in left:
            self._begin(self._delete(pid))

    async def _delete(self, pid: str) -> None:
        """Delete answers and recordings once the last recording is on the disk, and look again for some time.

        The code stays, for the payment. Another node may finish a recording, and tells nobody here when it does.
        """
        await self._rooms.finished.saved()
        await self._host.recording_service.settled()
        pauses = iter(LOOK_AGAIN_S)
        while True:
            done = await self._delete_found(pid)
            pause = next(pauses, None if done else LOOK_AGAIN_S[-1])
            if pause is None or await self._ends_within(pause):
                return

    async def _delete_found(self, pid: str) -> bool:
        """Whether it could be deleted."""
        store, run = self._databases.store, self._databases.run
        try:
            episodes = set(await run(episodes_of, store, pid))
            await self._wait_until_recorded(pid, episodes)
            played = [row for row in await run(store.rows, rounds) if row["episode"] in episodes]
            removed = await asyncio.to_thread(remove_recordings, self._recordings, pid, episodes)
            await run(withdraw_data, store, pid, removed)
            self._notes.forget(pid)
            self._rooms.finished.count_deleted(played)
            self._forget_last_round(pid)
        except Exception as error:  # noqa: BLE001 - the experimenter hears of it, and it is tried again
            self._alerts.add("deletion", f"The data of {pid} could not be deleted.", str(error), pid=pid)
            return False
        return True

    def _forget_last_round(self, pid: str) -> None:
        """Nobody can mark it any more."""
        session = self._participants.get(pid)
        if session is not None and session.record.unit is not None:
            self._units.last_rounds.pop(session.record.unit, None)

    async def _wait_until_recorded(self, pid: str, episodes: set[str]) -> None:
        """Whoever finishes a recording would write it again if it were deleted meanwhile."""
        deadline = time.monotonic() + FINISHED_S
        while await asyncio.to_thread(is_being_recorded, self._recordings, pid, episodes):
            if time.monotonic() > deadline or await self._ends_within(LOOK_S):
                return

    async def _ends_within(self, seconds: float) -> bool:
        """Whether the study is ended here by then."""
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._ending.wait(), seconds)
        return self._ending.is_set()

    async def end(self) -> None:
        """Wait until every deletion that has begun is done; the next start looks for what comes later."""
        self._ending.set()
        while self._deletions:
            await asyncio.gather(*self._deletions, return_exceptions=True)
