"""Deletes the data of participants who asked for it: of all together, so that many cost little more than one."""

import asyncio
import contextlib
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from movingout.server.public_host import PublicHost
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.notes import ExperimenterNotes
from movingout.server.study.participants import SCRUB_S, Participants
from movingout.server.study.rounds.finished_rounds import FinishedRounds
from movingout.server.study.rounds.round_recovery import FINISHED_S
from movingout.server.study.units import Units
from movingout.study.data.erasure import being_recorded, remove_recordings_of
from movingout.study.errors import StoreError
from movingout.study.store.removal import rounds_by_participant, withdraw_data

LOOK_S = 0.5  # between two looks at whose turn it is
LOOK_AGAIN_S = (10.0, 60.0, 600.0)  # after a deletion; the last one again and again while it fails

Played = Mapping[str, Sequence[dict[str, Any]]]
"""Rounds by pseudonym, of all who have a unit: nobody else can be in a recording."""


@dataclass(slots=True)
class _Wish:
    """Of one participant, to have their data deleted: when it is looked for next."""

    at: float
    began: bool = False
    coming_until: float | None = None  # a recording that is being finished is waited for
    pauses: Iterator[float] = field(default_factory=lambda: iter(LOOK_AGAIN_S))


class Deletions:
    """In the background; after a kill they are done at the next start. One look at the files is for all who are due.

    What comes later is looked for some time: another node may finish a recording, and tells nobody here when it does.
    """

    def __init__(
        self,
        recordings: Path,
        host: PublicHost,
        databases: StudyDatabases,
        alerts: Alerts,
        participants: Participants,
        units: Units,
        finished: FinishedRounds,
        notes: ExperimenterNotes,
    ) -> None:
        self._recordings = recordings
        self._host = host
        self._databases = databases
        self._alerts = alerts
        self._participants = participants
        self._units = units
        self._finished = finished
        self._notes = notes
        self._wishes: dict[str, _Wish] = {}
        self._unscrubbed = False  # whether rows were deleted since the database was scrubbed
        self._scrub_at = float("-inf")
        self._ending = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def add(self, pid: str) -> None:
        """From now on, and from the start again of who has asked before."""
        self._wishes[pid] = _Wish(time.monotonic())
        self._begin()

    def resume(self, pids: Iterable[str], unscrubbed: bool) -> None:
        """At a start: what is still there, or came since, of those who asked for it; a kill may have left traces.

        One look, and the further ones only where it finds something.
        """
        now = time.monotonic()
        self._wishes |= {pid: _Wish(now, pauses=iter(())) for pid in pids}
        if unscrubbed:
            self._unscrubbed, self._scrub_at = True, now + SCRUB_S
        if self._wishes or unscrubbed:
            self._begin()

    def _begin(self) -> None:
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._run())

    async def end(self) -> None:
        """Wait until every deletion has been begun that was asked for; the next start looks for what comes later."""
        self._ending.set()
        if self._task is not None:
            await asyncio.gather(self._task, return_exceptions=True)

    async def _run(self) -> None:
        while self._wishes or self._unscrubbed:
            ending, now = self._ending.is_set(), time.monotonic()
            due = [pid for pid, one in self._wishes.items() if (not one.began if ending else one.at <= now)]
            if due:
                await self._look(due)
            if self._unscrubbed and (ending or time.monotonic() >= self._scrub_at):
                await self._scrub()
            if ending:
                return
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._ending.wait(), LOOK_S)

    async def _look(self, pids: Sequence[str]) -> None:
        """Delete what is there, once the last recording is on the disk. The codes stay, for the payment."""
        try:
            await self._finished.saved()
            played = await self._databases.run(rounds_by_participant, self._databases.store, pids)
        except Exception as error:  # noqa: BLE001 - the experimenter hears of it, and it is tried again
            self._failed(pids, error)
            return
        await self._delete([pid for pid in pids if pid not in played], {})
        if played:
            await self._host.recording_service.settled()
            coming = await self._coming(played)
            await self._delete([pid for pid in played if pid not in coming], played)

    async def _coming(self, played: Played) -> set[str]:
        """Whose recording is still being finished: whoever does that would write it again if it were deleted now."""
        try:
            found: set[str] = await self._compute(partial(being_recorded, self._recordings, _episodes(played)))
        except Exception:  # noqa: BLE001 - then the deletion fails too, and says so
            return set()
        now, coming = time.monotonic(), set[str]()
        for wish, pid in [(self._wishes[pid], pid) for pid in found]:
            wish.coming_until = now + FINISHED_S if wish.coming_until is None else wish.coming_until
            if now < wish.coming_until and not self._ending.is_set():
                coming.add(pid)
        return coming

    async def _delete(self, pids: Sequence[str], played: Played) -> None:
        """All at once; where that fails, one by one."""
        if not pids:
            return
        mine = {pid: played[pid] for pid in pids if pid in played}
        try:
            await self._delete_found(pids, mine)
        except Exception as error:  # noqa: BLE001 - the experimenter hears of it, and it is tried again
            if len(pids) == 1:
                self._failed(pids, error)
                return
            for pid in pids:
                await self._delete([pid], mine)
            return
        self._looked_at(pids)

    async def _delete_found(self, pids: Sequence[str], played: Played) -> None:
        """Recordings first: while they are there, the rows lead to them."""
        removed: dict[str, int] = {}
        if played:
            removed = await self._compute(partial(remove_recordings_of, self._recordings, _episodes(played)))
        recordings = {pid: removed.get(pid, 0) for pid in pids}
        rows = await self._databases.run(withdraw_data, self._databases.store, recordings)
        self._unscrubbed |= rows > 0
        if rows:
            self._notes.forget(pids)
        if rows or any(removed.values()):
            self._look_again(pids)
        rounds = {row["episode"]: row for mine in played.values() for row in mine}  # of a pair once
        self._finished.count_deleted([*rounds.values()])
        for pid in played:
            self._forget_last_round(pid)

    async def _compute(self, work: partial[Any]) -> Any:
        """In the process that reads recordings: ticks do not wait for it."""
        return await self._host.recording_service.compute(work, urgent=True)

    def _forget_last_round(self, pid: str) -> None:
        """Nobody can mark it any more."""
        session = self._participants.get(pid)
        if session is not None and session.record.unit is not None:
            self._units.last_rounds.pop(session.record.unit, None)

    def _look_again(self, pids: Iterable[str]) -> None:
        """Something was there, and more may come: also of those of whom a start takes one look."""
        for wish in [self._wishes[pid] for pid in pids]:
            if not wish.began:
                wish.pauses = iter(LOOK_AGAIN_S)

    def _failed(self, pids: Collection[str], error: Exception) -> None:
        for pid in pids:
            self._alerts.add("deletion", f"The data of {pid} could not be deleted.", str(error), pid=pid)
        self._looked_at(pids, LOOK_AGAIN_S[-1])

    def _looked_at(self, pids: Iterable[str], last_pause: float | None = None) -> None:
        """Look again after a pause; after the last one only where it failed."""
        now = time.monotonic()
        for pid in pids:
            wish = self._wishes[pid]
            pause = next(wish.pauses, last_pause)
            wish.began, wish.coming_until = True, None
            if pause is None:
                del self._wishes[pid]
            else:
                wish.at = now + pause

    async def _scrub(self) -> None:
        """Overwrite what was deleted: dear, so for all together."""
        self._scrub_at = time.monotonic() + SCRUB_S
        with contextlib.suppress(StoreError):  # the experimenter was alerted, and it is tried again
            await self._databases.run(self._databases.store.database.scrub)
            self._unscrubbed = False


def _episodes(played: Played) -> dict[str, set[str]]:
    return {pid: {str(row["episode"]) for row in rows} for pid, rows in played.items()}
