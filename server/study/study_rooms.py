"""Rooms for the rounds of a study: opened with a row in the database, and saved when they are over.

No tick can precede the row: nobody gets a key to the room before the database has accepted the round, which requires
that everybody in it has consented.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager

from movingout.maps import MapSpec
from movingout.maps.errors import MovingOutError
from movingout.recordings import RecordingError
from movingout.recordings.episode import Outcome
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.host import Host
from movingout.server.notices import Notice
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTARTED
from movingout.server.security.tokens import hash_token, new_token
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.room_setup import RoomSetup
from movingout.server.study.round_outcomes import (
    NOT_RECORDED,
    player_outcomes,
    recovered_players,
    recovered_round,
    round_outcome,
)
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import FinishedRound, RunningRound, StudyUnit
from movingout.server.study.units import Units
from movingout.study.design.steps import Step
from movingout.study.errors import StoreError, StudyError
from movingout.study.store.rounds import PlayerOutcome
from movingout.study.store.tables import rounds

log = logging.getLogger(__name__)

CANNOT_START = Notice("cannot_start", "This round cannot start.")
ROUND_OVER = Notice("round_over", "This round is over.")
LEAVE_S = 60.0  # how long somebody may look at the end of a round before its room is closed
OnSaved = Callable[[Transaction, StudyUnit, FinishedRound], Awaitable[None]]


class StudyRooms:
    """All rooms of a study. `on_saved` is awaited when the end of a round is in the database."""

    def __init__(
        self,
        setup: RoomSetup,
        host: Host,
        databases: StudyDatabases,
        alerts: Alerts,
        transaction: Callable[[], AbstractAsyncContextManager[Transaction]],
        on_saved: OnSaved,
    ) -> None:
        self._setup = setup
        self._host = host
        self._databases = databases
        self._alerts = alerts
        self._transaction = transaction
        self._on_saved = on_saved
        self.recorded = 0  # rounds with a recording
        self.partial = 0  # of them, those that a killed server has cut short
        self._units: dict[str, StudyUnit] = {}  # by room
        self._ended: list[tuple[Room, float]] = []  # rooms whose round is over, since when
        self._saving: set[asyncio.Task[None]] = set()
        host.registry.watch_rounds(self._round_over)

    # ---- before a round -----------------------------------------------------------------------------------------

    async def prepare(self, step: Step) -> None:
        """Make the randomised map of a round ahead, in another process."""
        await self._setup.prepare(step)

    def map_of(self, step: Step) -> MapSpec:
        """The map of a round or of the practice, after `prepare`."""
        return self._setup.map_of(step)

    def map_name(self, step: Step) -> str:
        """The map's name in the study file."""
        return self._setup.config(step).maps[0]

    async def open(self, tx: Transaction, unit: StudyUnit, step: Step) -> None:
        """Open a room for the unit. If that fails, the reason is in `unit.problem`, and the monitor tries again."""
        tx.check()
        unit.problem = self._host.full_disk().message
        if not unit.problem:
            try:
                await self._open(tx, unit, step)
            except MovingOutError as error:
                unit.problem = str(error)
        if unit.problem:
            self._alerts.add("room", f"Unit {unit.record.id} cannot play yet.", unit.problem, unit=unit.record.id)

    async def _open(self, tx: Transaction, unit: StudyUnit, step: Step) -> None:
        members = unit.members_at(step)
        keys = {session.pid: new_token() for session in members}
        room = self._host.registry.open(self._setup.config(step, unit), self._setup.seats(unit, step, keys))
        try:
            if step.turn is not None:
                players = [PlayerOutcome(one.pid, unit.seat_of(step, one), one.device or "keyboard") for one in members]
                await tx.run(self._databases.rounds.begin, unit.record, step, room.round.episode_id, players)
        except MovingOutError:
            self._remove(room, CANNOT_START)
            raise
        self._enter(unit, room, step, keys)

    def _enter(self, unit: StudyUnit, room: Room, step: Step, keys: dict[str, str]) -> None:
        seats = {one.pid: unit.seat_of(step, one) for one in unit.members_at(step)}
        unit.running_round = RunningRound(room, step, keys, seats)
        unit.episode = room.round.episode_id if step.turn else unit.episode
        unit.ready -= set(keys)
        self._units[room.id] = unit

    # ---- the end of a round -------------------------------------------------------------------------------------

    def close(self, tx: Transaction, unit: StudyUnit, notice: Notice, outcome: Outcome = "stopped") -> None:
        """End the round of a unit now."""
        tx.check()
        if unit.running_round is not None:
            room = unit.running_round.room
            self._remove(room, notice, outcome)
            self._end(room, room.round.result(0, outcome))

    def _remove(self, room: Room, notice: Notice, outcome: Outcome = "stopped") -> None:
        room.close(m.CLOSE_ROOM_OVER, notice, outcome)
        self._host.registry.remove(room)

    def _round_over(self, room_id: str, episode: str, result: m.Result) -> None:
        """Called by the room within its last tick, which cannot wait for a transaction."""
        unit = self._units.get(room_id)
        if unit is not None and unit.running_round is not None:
            self._end(unit.running_round.room, result)

    def _end(self, room: Room, result: m.Result) -> None:
        """Take the unit out of the room and begin to save the round. Does nothing the second time."""
        unit = self._units.pop(room.id, None)
        if unit is None or unit.running_round is None:
            return
        unit.finished_round = FinishedRound(
            unit.running_round.step,
            room.round.episode_id,
            round_outcome(room, result),
            player_outcomes(unit.running_round),
        )
        unit.running_round = None
        self.recorded += bool(result.recording) and not room.config.practice
        self._ended.append((room, asyncio.get_running_loop().time()))
        task = asyncio.create_task(self._save(unit))
        self._saving.add(task)
        task.add_done_callback(self._saving.discard)

    async def _save(self, unit: StudyUnit) -> None:
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

    # ---- each second --------------------------------------------------------------------------------------------

    async def check(self, tx: Transaction, units: Units, now: float, may_begin: bool) -> None:
        """Repeat what failed before, notice rooms that closed by themselves, close those that everybody has left."""
        tx.check()
        for unit in units:
            if unit.running_round is not None and unit.running_round.room.phase in ("series_over", "closed"):
                room = unit.running_round.room
                self._end(room, room.round.result(0, "stopped"))
            elif unit.finished_round is not None:
                await self.save(tx, unit)
            elif unit.problem and may_begin and not unit.paused:
                await self._open_again(tx, unit)
        for room, since in list(self._ended):
            if not room.seating.clients or now - since > LEAVE_S:
                self._ended.remove((room, since))
                self._remove(room, ROUND_OVER)

    async def _open_again(self, tx: Transaction, unit: StudyUnit) -> None:
        unit.problem = ""
        steps = [session.step for session in unit.members if session.pid in unit.ready]
        ready = next((step for step in steps if step is not None and unit.all_ready(step)), None)
        if unit.running_round is None and ready is not None:
            await self.open(tx, unit, ready)

    # ---- after a start of the server ----------------------------------------------------------------------------

    async def resume(self, tx: Transaction, units: Units) -> None:
        """Resume the rounds whose rooms were restored; close the other rooms, and save how their rounds ended."""
        unfinished = await tx.run(self._databases.rounds.open_episodes)
        for room in [room for room in self._host.registry.rooms.values() if room.config.study]:
            unit = units.get(unfinished.get(room.round.episode_id))
            step = unit.members[0].step if unit else None
            if unit and step and room.round.started and room.config.study.get("step") == step.key:
                self._adopt(unit, room, step)
            else:
                self._remove(room, RESTARTED)
        await self._host.recording_service.settled()
        ended = [row for row in await tx.run(self._databases.store.rows, rounds) if row["ticks"]]
        self.recorded, self.partial = len(ended), sum(row["outcome"] == "interrupted" for row in ended)
        resumed = {unit.episode for unit in units if unit.running_round}
        for episode in [one for one in unfinished if one not in resumed]:
            await self._recover(tx, episode, units.get(unfinished[episode]))

    def _adopt(self, unit: StudyUnit, room: Room, step: Step) -> None:
        keys = {session.pid: new_token() for session in unit.members_at(step)}
        for session in unit.members_at(step):
            room.seats[unit.seat_of(step, session)].key = hash_token(keys[session.pid])
        self._enter(unit, room, step, keys)

    async def _recover(self, tx: Transaction, episode: str, unit: StudyUnit | None) -> None:
        """Save the outcome of a round that a killed server did not save, as far as it was recorded."""
        outcome, players = NOT_RECORDED, list[PlayerOutcome]()
        try:
            found = await self._host.recording_service.read(episode, recovered_round)
            outcome, players = found.outcome, recovered_players(found, unit)
        except RecordingError as error:
            log.warning("the round %s has no recording: %s", episode, error)
            if (self._host.settings.recordings / f"{episode}{JOURNAL_SUFFIX}").exists():
                self._alerts.add(
                    "recovery", f"The recording {episode} cannot be finished.", str(error), episode=episode
                )
                return  # the row stays open, and the next start tries again
        try:
            await tx.run(self._databases.rounds.end, episode, outcome, players)
            self.recorded += outcome.ticks > 0
            self.partial += outcome.ticks > 0 and outcome.outcome == "interrupted"
        except StudyError as error:
            self._alerts.add(
                "not_closed", f"The round {episode} stays open in the database.", str(error), episode=episode
            )
