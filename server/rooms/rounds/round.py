"""One round: a world that is stepped ten times a second, and its events.

Knows no clock and no phase: the room says when to step.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from movingout.maps import MapSpec, map_to_json
from movingout.recordings import EpisodeHeader, EpisodeWriter, Event, SeatInfo
from movingout.recordings.episode import Episode, EventKind, Outcome
from movingout.server import messages as m
from movingout.server.frames import Bundle, BundleEvent, Input
from movingout.server.notices import NOTHING, Notice
from movingout.server.rooms.input_buffer import NEUTRAL, TickInput
from movingout.server.rooms.pause import PauseBudget
from movingout.server.rooms.rounds.deliverers import Deliverers
from movingout.server.rooms.rounds.pings import RoundPings
from movingout.server.rooms.rounds.quality import RoundQuality
from movingout.server.rooms.rounds.round_recorder import RoundRecorder
from movingout.server.rooms.seat import AgentPlayer, Seat
from movingout.server.rooms.tutorial import TutorialProgress
from movingout.world import World
from movingout.world.metrics import EpisodeMetrics, to_numbers
from movingout.world.ping import PING_TICKS
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

GRASP_POSE = (0, 2)  # blue's hand moves before the first sub-step, red's after half of them
LAST_POSE = m.POSES_PER_TICK - 1


class TickTiming(NamedTuple):
    """When a tick is due on the server's clock, and how late it is."""

    due: float  # [s]
    late_ms: float
    skipped: int  # ticks skipped before this one


class LiveRound:
    """A map being played for at most `limit_ticks` (0: for ever).

    A full disk or a lost folder ends the recording, never the round; then everybody in the room sees "not recording".
    """

    def __init__(
        self,
        map_spec: MapSpec,
        limit_ticks: int,
        epoch: int,
        episode_id: str,
        seed: int,
        tutorial: TutorialProgress | None = None,
    ) -> None:
        self.map = map_spec
        self.tutorial = tutorial
        self.limit_ticks = limit_ticks
        self.epoch = epoch
        self.episode_id = episode_id
        self.seed = seed
        self.recorder = RoundRecorder()
        self.started = False
        self.deadline_misses = 0
        self.quality = RoundQuality()
        self._world = World(map_spec)
        self.state: WorldState = self._world.state()
        self.delivered: tuple[bool, ...] = tuple(self._world.delivered().tolist())
        self._metrics = EpisodeMetrics(map_spec)
        self._deliverers = Deliverers(len(map_spec.items))
        self._pending: list[BundleEvent] = []  # to be shown with the next tick
        self._learned = False  # in the last tick: a step of the tutorial, or a player's part in it
        self.pings = RoundPings()
        self.pauses = PauseBudget()

    def begin(self, writer: EpisodeWriter | None, problem: Notice = NOTHING) -> None:
        """The countdown is over; `problem` is why the round is not recorded though it should be."""
        self.recorder.begin(writer)
        self.recorder.problem = problem
        self.started = True
        self.recorder.event(Event(0, "start"))

    def resume(self, episode: Episode, writer: EpisodeWriter) -> None:
        """Restore the state at the end of an interrupted recording, and go on recording."""
        self.episode_id = episode.header.episode_id
        for actions in episode.actions:
            self._advance(actions)
        focus = [event for event in episode.events if event.kind == "focus"]
        for number, tick in enumerate(episode.ticks, 1):
            for event in focus:
                if event.tick == number:
                    self.quality.focus(event.seat, event.detail == "visible")
            self.quality.tick(tick.actions, tick.rtt_ms, tick.late_ms)
        self.recorder.begin(writer)
        self.started = True

    def note(self, kind: EventKind, seat: int = -1, item: int = -1, detail: str = "", pose: int = 0) -> None:
        """Record an event of the coming tick; events that players see go out with its bundle."""
        self.recorder.event(Event(tick=self.state.tick + 1, kind=kind, seat=seat, item=item, detail=detail))
        if kind in m.EVENT:
            self._show(kind, seat, item, pose)

    def note_focus(self, seats: Sequence[Seat]) -> None:
        """Record which pages are hidden, or visible again, since they last were noted."""
        for seat in seats:
            if self.quality.focus(seat.index, seat.visible):
                self.note("focus", seat.index, detail="visible" if seat.visible else "hidden")

    def note_drop(self, seat: Seat, seats: Sequence[Seat]) -> None:
        """A player's connection is lost: recorded, and counted where others wait, who do not wait again and again."""
        self.note("drop", seat.index)
        self.pauses.drop(seat, seats)

    def note_skip(self, seat: int) -> None:
        """Record that a player ends the tutorial here, and at which step."""
        if self.tutorial is not None:
            self.note("tutorial_skipped", seat, detail=self.tutorial.step)

    def record_input(self, frame: Input, rtt_ms: float) -> None:
        """Record a raw input for the coming tick."""
        self.recorder.input(frame, self.state.tick + 1, rtt_ms)

    def ping(self, seat: int, item: int, now: float) -> m.ShownPing:
        """Record "help here" and show it to the agents. Raises WrongRequest for no item, or too many pings."""
        ping = self.pings.say(self.state, seat, item, now)
        self.recorder.event(Event(ping.tick, "ping", seat, item))
        return m.ShownPing(epoch=self.epoch, ticks=PING_TICKS, **ping._asdict())

    def step(self, seats: Sequence[Seat], now: float, timing: TickTiming) -> bytes:
        """Take the input of each seat, advance by one tick, record it, and return its bundle. Never waits.

        Raises WorldError when the simulation produces numbers that are not finite.
        """
        inputs = [self._tick_input(seat, now) for seat in seats]
        if timing.skipped:
            self.note("tick_skipped", detail=str(timing.skipped))
        actions = np.array([each.action for each in inputs], dtype=np.float64)  # (2, 3)
        held, delivered = self.state.held.tolist(), self.delivered
        self._advance(actions)
        poses = self._world.sub_poses()  # (5, 2 + N, 3)
        self._note_hands(actions, held)
        self._note_deliveries(delivered, poses)
        if self.tutorial is not None and self._learned:
            detail = "finished" if self.tutorial.finished else self.tutorial.step
            self.recorder.event(Event(self.state.tick, "tutorial_step", detail=detail))
        rtt_ms = seats[0].rtt_ms, seats[1].rtt_ms
        self.quality.tick(actions, rtt_ms, timing.late_ms)
        self.recorder.tick(actions, inputs, seats, self.state, self.delivered, timing.late_ms)
        return self._bundle(poses, inputs, timing)

    def ask_agents(self, seats: Sequence[Seat], deadline: float) -> None:
        """Give the state to the agents; they answer by `deadline`, when the next tick starts."""
        for seat in seats:
            if seat.player is not None:
                seat.player.observe(self.state, self.state.tick, deadline, self.pings.shown(self.state.tick))

    def outcome(self) -> Outcome | None:
        """How the round has ended, None while it goes on; a tutorial is over when its last step is done."""
        if all(self.delivered) if self.tutorial is None else self.tutorial.over(self.state.tick):
            return "delivered"
        return "time" if self.limit_ticks and self.state.tick >= self.limit_ticks else None

    def suspend(self) -> None:
        """Leave the recording as it is, to be resumed."""
        self.recorder.suspend()

    def finish(self, outcome: Outcome) -> Path | None:
        """Record the end; returns the journal to finalise, None without a recording."""
        for seat, number in self.pings.refused.items():
            self.recorder.event(Event(self.state.tick, "pings_refused", seat, detail=str(number)))
        self.recorder.event(Event(self.state.tick, "end", detail=outcome))
        return self.recorder.finish(outcome)

    @property
    def is_recorded(self) -> bool:
        """Whether a recording is being written."""
        return self.recorder.is_recording

    def result(self, index: int, outcome: Outcome) -> m.Result:
        """The result to announce; call before `finish`."""
        numbers = to_numbers(self._metrics.result().values())
        return m.Result(
            index=index,
            outcome=outcome,
            ticks=self.state.tick,
            delivered=sum(self.delivered),
            items=len(self.delivered),
            tcr=numbers["tcr"],
            nfd=numbers["nfd"],
            wt_s=numbers["wt_s"],
            ac=numbers["ac"],
            recording=self.episode_id if self.is_recorded else "",
            metrics=numbers,
            delivered_by=self._deliverers.of(self.delivered),
        )

    def header(
        self, seats: tuple[SeatInfo, SeatInfo], started_ns: int, study: Mapping[str, str] | None = None
    ) -> EpisodeHeader:
        """The header of the recording."""
        return EpisodeHeader(
            episode_id=self.episode_id,
            map=self.map,
            seed=self.seed,
            limit_ticks=self.limit_ticks,
            seats=seats,
            started_ns=started_ns,
            source="live" if self.tutorial is None else "tutorial",
            study=study or {},
        )

    def message(self, index: int, total: int, practice: bool) -> m.Round:
        """What clients need to draw this round."""
        the_map = map_to_json(self.map)
        return m.Round(
            index=index,
            total=total,
            epoch=self.epoch,
            map=the_map,
            limit_ticks=self.limit_ticks,
            practice=practice,
            episode=self.episode_id,
        )

    def learned(self) -> m.Tutorial | None:
        """What is new in the tutorial since the last tick, None for nothing."""
        return self.tutorial.message() if self.tutorial is not None and self._learned else None

    def full_state(self, time_ms: float) -> m.FullState:
        poses = [*self.state.robot_poses.tolist(), *self.state.item_poses.tolist()]
        return m.FullState(
            epoch=self.epoch,
            tick=self.state.tick,
            time_ms=time_ms,
            poses=poses,
            held=self.state.held.tolist(),
            delivered=list(self.delivered),
        )

    def _tick_input(self, seat: Seat, now: float) -> TickInput:
        """What `seat` does in the tick that starts at `now`: the newest input of a client, the answer of an agent."""
        if seat.player is not None:
            return self._agent_input(seat.index, seat.player)
        return seat.controls.tick_input(now) if seat.client is not None else NEUTRAL

    def _agent_input(self, seat: int, player: AgentPlayer) -> TickInput:
        answer = player.answer(self.state.tick)
        self.recorder.decision(answer, self.state.tick + 1, seat)
        if answer.missed:
            self.deadline_misses += 1
            self.note("deadline_missed", seat)
        if answer.problem:
            self.note("agent_error", seat, detail=answer.problem)
        return TickInput(answer.action, -1, -1.0, not answer.missed)

    def _advance(self, actions: Floats) -> None:
        before = self.state
        self._world.step(actions)
        self.state = self._world.state()
        self.delivered = tuple(self._world.delivered().tolist())
        self._metrics.update(before, actions, self.state)
        self._deliverers.see(self.state.tick, self.state.held.tolist())
        self._learned = self.tutorial is not None and self.tutorial.update(before, self.state, self.delivered)

    def _note_hands(self, actions: Floats, held: list[int]) -> None:
        tick = self.state.tick
        for seat, item in enumerate(self.state.held.tolist()):
            kind: EventKind
            if held[seat] < 0 <= item:
                kind = "grab"
            elif item < 0 <= held[seat]:
                kind, item = "release", held[seat]
            elif actions[seat, 2] > 0.5:
                kind = "grab_failed"
            else:
                continue
            self.recorder.event(Event(tick, kind, seat, item))
            self._show(kind, seat, item, GRASP_POSE[seat])

    def _note_deliveries(self, before: tuple[bool, ...], poses: Floats) -> None:
        if before == self.delivered:
            return
        flags = [delivered_items(self.map, each) for each in poses[:, 2:]]
        for item, now in enumerate(self.delivered):
            if now == before[item]:
                continue
            kind: EventKind = "delivered" if now else "undelivered"
            pose = next((index for index, flag in enumerate(flags) if bool(flag[item]) == now), LAST_POSE)
            self.recorder.event(Event(self.state.tick, kind, -1, item))
            self._show(kind, -1, item, pose)

    def _show(self, kind: EventKind, seat: int, item: int, pose: int) -> None:
        """Add an event to the next bundle."""
        self._pending.append(BundleEvent(code=m.EVENT[kind], seat=seat, item=item, pose=pose))

    def _bundle(self, poses: Floats, inputs: Sequence[TickInput], timing: TickTiming) -> bytes:
        blue, red = inputs
        flags = (0 if self.is_recorded else m.FLAG_NOT_RECORDING) | (m.FLAG_SKIPPED if timing.skipped else 0)
        held_blue, held_red = self.state.held.tolist()
        events, self._pending = tuple(self._pending), []
        return Bundle(
            flags=flags,
            epoch=self.epoch,
            tick=self.state.tick,
            time_ms=timing.due * 1e3,
            seqs=(max(0, blue.seq), max(0, red.seq)),
            slack_ms=(blue.slack_ms, red.slack_ms),
            held=(held_blue, held_red),
            delivered=self.delivered,
            poses=poses,
            events=events,
        ).encode()
