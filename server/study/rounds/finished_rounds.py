"""Rounds that are over: each is saved in the database, and its room is closed when everybody has left it."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable, Sequence
from contextlib import AbstractAsyncContextManager
from typing import Any

from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.public_host import Away, NoRoom, PublicHost
from movingout.server.rooms.room_view import PlayedRound
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import FinishedRound, StudyUnit
from movingout.study.errors import StoreError, StoreFenced, StudyError
from movingout.study.store.rounds import RoundOutcome

log = logging.getLogger(__name__)

ROUND_OVER = Notice("round_over", "This round is over.")
LEAVE_S = 60.0  # how long somebody may look at the end of a round before its room is closed
OnSaved = Callable[[Transaction, StudyUnit, FinishedRound], Awaitable[None]]


class FinishedRounds:
    """`on_saved` is awaited when the end of a round is in the database."""

    def __init__(
        self,
        host: PublicHost,
        databases: StudyDatabases,
        transaction: Callable[[], AbstractAsyncContextManager[Transaction]],
        on_saved: OnSaved,
    ) -> None:
        self._host = host
        self._databases = databases
        self._transaction = transaction
        self._on_saved = on_saved
        self.recorded = 0  # rounds with a recording
        self.deleted = 0  # of them, those whose players asked for it since the start
        self.partial = 0  # of those that are left, those that a killed server has cut short
        self._rooms: list[tuple[str, float]] = []  # that are still open, since when the round is over
        self._saving: set[asyncio.Task[None]] = set()

    def add(self, unit: StudyUnit, room_id: str, finished: FinishedRound) -> None:
        """Take the unit out of a room whose round is over."""
        unit.finished_round, unit.running_round = finished, None
        self._rooms.append((room_id, time.monotonic()))

    # ---- the database -------------------------------------------------------------------------------------------

    def save_soon(self, unit: StudyUnit) -> None:
        """Save the round of a unit in a transaction of its own."""
        task = asyncio.create_task(self._save(unit))
        self._saving.add(task)
        task.add_done_callback(self._saving.discard)

    async def _save(self, unit: StudyUnit) -> None:
        with contextlib.suppress(StoreFenced):  # the node that goes on with the study saves it
            async with self._transaction() as tx:
                await self.save(tx, unit)

    async def save(self, tx: Transaction, unit: StudyUnit) -> None:
        """Save `unit.finished_round`, if there is one; it is kept if the database refuses."""
        tx.check()
        finished = unit.finished_round
        if finished is None:
            return
        try:
            if finished.step.turn is not None:
                await tx.run(self._databases.rounds.end, finished.episode, finished.outcome, finished.players)
            await self._on_saved(tx, unit, finished)
        except StoreError:
            return  # the experimenter was alerted; the monitor tries again
        except StudyError as error:  # the data were deleted meanwhile
            log.warning("the round %s is not saved: %s", finished.episode, error)
        unit.finished_round = None

    async def saved(self) -> None:
        """Wait until every save that has begun has ended."""
        await asyncio.gather(*self._saving, return_exceptions=True)

    # ---- how many -----------------------------------------------------------------------------------------------

    @property
    def left(self) -> int:
        """Rounds whose recording nobody asked to delete."""
        return max(0, self.recorded - self.deleted)

    def count(self, played: PlayedRound) -> None:
        self.recorded += bool(played.result.recording) and not played.practice

    def count_recovered(self, outcome: RoundOutcome) -> None:
        """Of a round whose end was read from its recording."""
        self.recorded += outcome.ticks > 0
        self.partial += outcome.ticks > 0 and outcome.outcome == "interrupted"

    def count_stored(self, rows: Sequence[dict[str, Any]]) -> None:
        """Begin with the rounds of the database."""
        ended = [row for row in rows if row["ticks"]]
        self.recorded, self.partial = len(ended), sum(row["outcome"] == "interrupted" for row in ended)

    def count_deleted(self, rows: Sequence[dict[str, Any]]) -> None:
        """Of rounds that were in the database."""
        ended = [row for row in rows if row["ticks"]]
        self.deleted += len(ended)
        self.partial -= sum(row["outcome"] == "interrupted" for row in ended)

    # ---- their rooms --------------------------------------------------------------------------------------------

    async def close_left(self, now: float) -> None:
        """Close the rooms that everybody has left."""
        views = await self._host.look([room_id for room_id, _ in self._rooms])
        for room_id, since in [one for one in self._rooms if one[0] in views]:
            view = views[room_id]
            if view is None or not view.clients or now - since > LEAVE_S:
                with contextlib.suppress(Away):
                    await close_room(self._host, room_id, ROUND_OVER)
                    self._rooms.remove((room_id, since))


async def close_room(
    host: PublicHost, room_id: str, notice: Notice, outcome: Outcome = "stopped"
) -> PlayedRound | None:
    """Close a room of a study; None when it is gone. Raises Away."""
    try:
        return await host.close_room(room_id, m.CLOSE_ROOM_OVER, notice, outcome)
    except NoRoom:
        return None
