"""Rooms for the rounds of a study: opened with a row in the store, and written down when they are over.

No tick can come before the row: nobody has a key to the room until the store has accepted the round, which it does
only when everybody in it has consented.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Collection, Mapping

from movingout.maps import MapSpec
from movingout.maps.errors import MovingOutError
from movingout.recordings import RecordingError
from movingout.recordings.episode import Outcome
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.host import Host
from movingout.server.rooms.room import Room
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import hash_token, new_token
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.round_recovery import recovered
from movingout.server.study.unit import FinishedRound, RunningRound, StudyUnit
from movingout.study.design.allocation import letters
from movingout.study.design.definition import Study
from movingout.study.design.steps import Step
from movingout.study.errors import StoreError, StudyError
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome
from movingout.study.store.tables import rounds
from movingout.world.metrics import from_numbers

log = logging.getLogger(__name__)

LEAVE_S = 60.0  # who still looks at the end of a round has this long
PARTNER = "Partner"  # the agent of the practice


class StudyRooms:
    """All rooms of a study. `on_over` is awaited, with the lock held, when a round is written down."""

    def __init__(
        self,
        study: Study,
        names: Mapping[str, str],
        host: Host,
        databases: StudyDatabases,
        alerts: Alerts,
        lock: asyncio.Lock,
        on_over: Callable[[StudyUnit, FinishedRound], Awaitable[None]],
    ) -> None:
        self._study = study
        self._names = names  # for recordings
        self._host = host
        self._databases = databases
        self._alerts = alerts
        self._lock = lock
        self._on_over = on_over
        self.recorded = 0  # rounds with a recording
        self.partial = 0  # of them, those that a killed server has cut short
        self._letters = letters(study)
        self._splits = {block.id: block.split for block in study.blocks}
        self._units: dict[str, StudyUnit] = {}  # by room
        self._left: list[tuple[Room, float]] = []  # rooms whose round is over, since when
        self._writing: set[asyncio.Task[None]] = set()
        host.directory.watch_rounds(self._ended)

    # ---- before a round -----------------------------------------------------------------------------------------

    async def prepare(self, step: Step) -> None:
        """Make the randomised map of a round ahead, in another process."""
        if step.turn is not None and step.turn.variant_seed is not None:
            await self._host.prepare_maps(self._config(step, {}))

    def map_of(self, step: Step) -> MapSpec:
        """The map of a round or of the practice, after `prepare`."""
        config = self._config(step, {})
        return self._host.directory.load_map(config.maps[0], config.challenge2_seed, config.split)

    async def open(self, unit: StudyUnit, step: Step) -> None:
        """Let the unit into a room. What is in the way is left in `unit.problem`, to be tried again."""
        unit.problem = self._host.full_disk()
        if not unit.problem:
            try:
                await self._open(unit, step)
            except MovingOutError as error:
                unit.problem = str(error)
        if unit.problem:
            self._alerts.raise_("room", f"Unit {unit.record.id} cannot play yet: {unit.problem}")

    async def _open(self, unit: StudyUnit, step: Step) -> None:
        keys = {session.pid: new_token() for session in unit.at(step)}
        names = {**self._names, "unit": str(unit.record.id), "step": step.key}
        room = self._host.directory.open(self._config(step, names), self._seats(unit, step, keys))
        try:
            if step.turn is not None:
                seated = [
                    PlayerOutcome(one.pid, unit.seat_of(step, one), one.device or "keyboard") for one in unit.at(step)
                ]
                await self._databases.run(
                    self._databases.rounds.begin, unit.record, step, room.round.episode_id, seated
                )
        except MovingOutError:
            self._remove(room, "This round cannot begin.")
            raise
        self._enter(unit, room, step, keys)

    def _enter(self, unit: StudyUnit, room: Room, step: Step, keys: dict[str, str]) -> None:
        unit.running_round = RunningRound(room, step, keys, {one.pid: unit.seat_of(step, one) for one in unit.at(step)})
        unit.episode = room.round.episode_id if step.turn else unit.episode
        unit.ready -= set(keys)
        self._units[room.id] = unit

    def _config(self, step: Step, names: dict[str, str]) -> RoomConfig:
        practice = self._study.practice
        return RoomConfig(
            maps=(step.turn.map if step.turn else practice.map if practice else "",),
            limit_ticks=step.limit_ticks,
            practice=step.turn is None,
            challenge2_seed=step.turn.variant_seed if step.turn else None,
            split=self._splits.get(step.block, "train"),
            countdown_s=self._host.settings.countdown_s,
            resume_s=float(self._study.pairing.return_s),
            study=names,
        )

    def _seats(self, unit: StudyUnit, step: Step, keys: Mapping[str, str]) -> list[Seat]:
        """Whoever plays, each with a key of their own; an agent where nobody else sits, named by its letter.

        A seat stands idle in practice when its owner has had enough of it.
        """
        seats = {}
        for session in unit.members:
            index = unit.seat_of(step, session)
            key = keys.get(session.pid)
            human = Seat(index, "human", alias=session.pid, key=hash_token(key)) if key else None
            seats[index] = human or Seat(index, "idle", name="idle")
        for index in {0, 1} - set(seats):
            agent = self._agent(step)
            kind = "idle" if agent == "idle" else "agent"
            seats[index] = Seat(index, kind, agent, name=self._letters.get(step.partner, PARTNER))  # type: ignore[arg-type]
        return [seats[0], seats[1]]

    def _agent(self, step: Step) -> str:
        if step.partner:
            return self._study.partner(step.partner).agent
        if self._study.group == 1 and self._study.practice:
            return self._study.practice.agent
        return self._study.pairing.agent

    # ---- the end of a round -------------------------------------------------------------------------------------

    def close(self, unit: StudyUnit, message: str, outcome: Outcome = "stopped") -> None:
        """End the round of a unit now."""
        if unit.running_round is not None:
            room = unit.running_round.room
            self._remove(room, message, outcome)
            self._end(room, room.round.result(0, outcome))

    def _remove(self, room: Room, message: str, outcome: Outcome = "stopped") -> None:
        room.close(m.CLOSE_ROOM_OVER, message, outcome)
        self._host.directory.remove(room)

    def _ended(self, room_id: str, episode: str, result: m.Result) -> None:
        """Called by the room, within its last tick."""
        unit = self._units.get(room_id)
        if unit is not None and unit.running_round is not None:
            self._end(unit.running_round.room, result)

    def _end(self, room: Room, result: m.Result) -> None:
        """Take the unit out of the room, and begin to write down what came of it. Once per room."""
        unit = self._units.pop(room.id, None)
        if unit is None or unit.running_round is None:
            return
        unit.finished_round = FinishedRound(
            unit.running_round.step, room.round.episode_id, _played(room, result), _seated(unit.running_round)
        )
        unit.running_round = None
        self.recorded += bool(result.recording)
        self._left.append((room, asyncio.get_running_loop().time()))
        task = asyncio.create_task(self._write(unit))
        self._writing.add(task)
        task.add_done_callback(self._writing.discard)

    async def _write(self, unit: StudyUnit) -> None:
        async with self._lock:
            await self.write_down(unit)

    async def write_down(self, unit: StudyUnit) -> None:
        """Keep what came of a round; where the database refuses it waits in `unit.finished_round`. The lock is held."""
        over = unit.finished_round
        if over is None:
            return
        try:
            if over.step.turn is not None:
                await self._databases.run(self._databases.rounds.end, over.episode, over.outcome, over.players)
            await self._on_over(unit, over)
        except StoreError:
            return  # the experimenter knows; it is tried again each second
        except StudyError as error:  # its data were deleted meanwhile
            log.warning("the round %s is not written down: %s", over.episode, error)
        unit.finished_round = None

    async def finish(self) -> None:
        """Wait for what is being written down."""
        await asyncio.gather(*self._writing, return_exceptions=True)

    # ---- each second --------------------------------------------------------------------------------------------

    async def look_after(self, units: Collection[StudyUnit], now: float, may_begin: bool) -> None:
        """Open and write down what could not be before; notice rooms that closed by themselves. The lock is held."""
        for unit in units:
            if unit.running_round is not None and unit.running_round.room.phase in ("series_over", "closed"):
                self._end(unit.running_round.room, unit.running_round.room.round.result(0, "stopped"))
            elif unit.finished_round is not None:
                await self.write_down(unit)
            elif unit.problem and may_begin and not unit.paused:
                await self._try_again(unit)
        for room, since in list(self._left):
            if not room.seating.clients or now - since > LEAVE_S:
                self._left.remove((room, since))
                self._remove(room, "This round is over.")

    async def _try_again(self, unit: StudyUnit) -> None:
        unit.problem = ""
        steps = [session.step for session in unit.members if session.pid in unit.ready]
        ready = next((step for step in steps if step is not None and unit.all_ready(step)), None)
        if unit.running_round is None and ready is not None:
            await self.open(unit, ready)

    # ---- after a start of the server ----------------------------------------------------------------------------

    async def take_up(self, units: Mapping[int, StudyUnit]) -> None:
        """Go on in the rooms that came back in the middle of a round; close what did not."""
        rooms = [room for room in self._host.directory.rooms.values() if room.config.study]
        unfinished = await self._databases.run(self._databases.rounds.open_episodes)
        for room in rooms:
            unit = units.get(unfinished.get(room.round.episode_id, -1))
            step = unit.members[0].step if unit else None
            if unit and step and room.round.started and room.config.study.get("step") == step.key:
                self._adopt(unit, room, step)
            else:
                self._remove(room, "The server was restarted; this round begins anew.")
        await self._host.archive.settled()
        ended = [row for row in await self._databases.run(self._databases.store.rows, rounds) if row["ticks"]]
        self.recorded, self.partial = len(ended), sum(row["outcome"] == "interrupted" for row in ended)
        for episode in unfinished:
            if not any(unit.running_round and unit.episode == episode for unit in units.values()):
                await self._recover(episode, [unit for unit in units.values() if unit.record.id == unfinished[episode]])

    def _adopt(self, unit: StudyUnit, room: Room, step: Step) -> None:
        keys = {session.pid: new_token() for session in unit.at(step)}
        for session in unit.at(step):
            room.seats[unit.seat_of(step, session)].key = hash_token(keys[session.pid])
        self._enter(unit, room, step, keys)

    async def _recover(self, episode: str, units: list[StudyUnit]) -> None:
        """Write down the end of a round that the server did not live to see."""
        played, seated = RoundOutcome("interrupted", 0, 0.0, 0.0, 0.0, None), []
        try:
            played, rtt_ms, idle_share = await self._host.archive.read(episode, recovered)
        except RecordingError as error:
            log.warning("the round %s has no recording: %s", episode, error)
            if (self._host.settings.recordings / f"{episode}{JOURNAL_SUFFIX}").exists():
                self._alerts.raise_("recovery", f"The recording of the round {episode} cannot be finished: {error}")
                return  # the row stays open, and the next start tries again
        else:
            seated = [
                PlayerOutcome(session.pid, seat, session.device or "keyboard", rtt_ms[seat], idle_share[seat])
                for unit in units
                for session in unit.members
                if (step := session.step) is not None
                for seat in [unit.seat_of(step, session)]
            ]
        try:
            await self._databases.run(self._databases.rounds.end, episode, played, seated)
            self.recorded += played.ticks > 0
            self.partial += played.ticks > 0 and played.outcome == "interrupted"
        except StudyError as error:
            self._alerts.raise_("recovery", f"The round {episode} stays open in the database: {error}")


def _played(room: Room, result: m.Result) -> RoundOutcome:
    return RoundOutcome(
        outcome=result.outcome,
        ticks=result.ticks,
        tcr=result.tcr,
        nfd=result.nfd,
        wt_s=result.wt_s,
        ac=from_numbers({"ac": result.ac})["ac"],
        late_ms=room.round.health.late_p99_ms(),
    )


def _seated(game: RunningRound) -> tuple[PlayerOutcome, ...]:
    health = game.room.round.health
    return tuple(
        PlayerOutcome(
            pid, seat, game.room.seats[seat].controls.device, health.rtt_ms(seat), health.idle_share(seat),
            health.hidden_s(seat),
        )
        for pid, seat in game.seats.items()
    )  # fmt: skip
