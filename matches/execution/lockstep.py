"""Plays many matches in one process, tick by tick together, so that agents of one kind decide in one batch.

The result of a match depends on the match alone, neither on the matches beside it nor on their order. A fault of an
agent ends its own match and no other: where a batch fails, each of its matches is played again on its own.
"""

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Literal

import numpy as np

from movingout.agents.base import Agent, EpisodeInfo, Watcher
from movingout.agents.catalogue import load_agent
from movingout.agents.decision_trace import decision_trace
from movingout.maps.errors import MapError
from movingout.maps.files.ctrl_c import noticing_ctrl_c
from movingout.matches.execution.batched_decisions import decide
from movingout.matches.execution.decision_timeout import DecisionTimer
from movingout.matches.execution.recorder import MatchRecorder
from movingout.matches.execution.seat import AgentFault, MatchSeat, attribute_agent_errors
from movingout.matches.match import Match, MatchResult, failed_result
from movingout.recordings.play_hash import PlayHash
from movingout.world import World, WorldError
from movingout.world.metrics import EpisodeMetrics
from movingout.world.own_metrics import own_metrics, own_values
from movingout.world.state import Floats, WorldState

AGENT_LIMIT_S = 20.0
LOADING_S = 120.0  # at least for making an agent, which may import a library for training
BATCH_SIZE = 32  # matches that advance together when all their agents decide in batches
SMALL_BATCH = 8  # the same for other agents: they gain little from a batch, and results come sooner

AgentLoader = Callable[[str], Agent]


class RunningMatch:
    """A match that is being played. Raises AgentFault when an agent cannot be reset."""

    def __init__(self, match: Match, agents: Sequence[Agent], record: Path | None, timer: DecisionTimer) -> None:
        self.match = match
        the_map = match.world_map()
        self.world = World(the_map, record_sub_poses=False)
        self.state = self.world.state()
        self.metrics = EpisodeMetrics(the_map)
        self._hash = PlayHash(the_map)
        self._played: list[tuple[WorldState, Floats]] = []  # states and what was done in them, for own metrics
        self.cpu_s = 0.0
        self._counts: dict[str, int] = {}
        self.seats: list[MatchSeat] = []
        for seat, (agent, agent_id) in enumerate(zip(agents, match.seats, strict=True)):
            episode = EpisodeInfo(the_map, seat, match.seed, match.ticks)
            with attribute_agent_errors(seat, agent_id, timer, "reset()"):
                agent.reset(episode)
                if isinstance(agent, Watcher):
                    agent.watch(self.world)
                self.seats.append(MatchSeat(agent, agent_id, episode, self.state))
        self.recorder = None if record is None else MatchRecorder(record, match, self.state)

    @property
    def over(self) -> bool:
        return self.state.tick >= self.match.ticks or self.world.score() == 1.0

    def keep_decision(self, seat: MatchSeat) -> None:
        """Record what the agent says about its latest decision."""
        if self.recorder is not None and (detail := decision_trace(seat.agent)):
            self.recorder.decision(seat.episode.seat, self.state.tick + 1, detail)

    def advance(self) -> None:
        """One tick with the next row of each seat. Raises WorldError when the physics gives NaN or infinity."""
        actions = np.array([seat.next_action() for seat in self.seats])
        before = self.state
        self.world.step(actions)
        self.state = self.world.state()
        for seat in self.seats:
            seat.state = self.state
        self.metrics.update(before, actions, self.state)
        self._hash.update(actions)
        if own_metrics():
            self._played.append((before, actions))
        if self.recorder is not None:
            self.recorder.tick(actions, self.state, self.world.delivered().tolist())

    def take_counts(self, timer: DecisionTimer) -> None:
        """Keep what agents counted. Raises AgentFault for one that did not play the match itself."""
        for seat in self.seats:
            with attribute_agent_errors(seat.episode.seat, seat.agent_id, timer, "its account"):
                self._counts |= seat.account()

    def result(self) -> MatchResult:
        """The result of a finished match; closes its recording."""
        flags = self.world.delivered().tolist()
        ending: Literal["delivered", "time"] = "delivered" if all(flags) else "time"
        path = "" if self.recorder is None else str(self.recorder.close(ending, self.state.tick))
        return MatchResult(
            match=self.match,
            ending=ending,
            ticks=self.state.tick,
            delivered=sum(flags),
            items=len(flags),
            metrics=self.metrics.result(),
            waiting_share=self.metrics.waiting_share,
            recording=path,
            cpu_s=self.cpu_s,
            play_hash=self._hash.of(self.state),
            own_metrics=self._own_values(),
            official_ac=self.metrics.official_ac,
            counts=self._counts,
        )

    def _own_values(self) -> dict[str, float | None]:
        if not self._played:
            return dict.fromkeys(metric.key for metric in own_metrics())
        states = [*(state for state, _ in self._played), self.state]
        return own_values(self.match.world_map(), states, np.array([actions for _, actions in self._played]))

    def abandon(self) -> None:
        """Stop without a result; what was recorded is removed, but for the journal of a match that ended."""
        if self.recorder is not None:
            self.recorder.discard()

    def fail(self, seat: int, reason: str) -> MatchResult:
        """The result of a match that failed; closes its recording."""
        tick = self.state.tick
        path = "" if self.recorder is None else str(self.recorder.close("error", tick, seat, reason))
        played = self._hash.of(self.state)
        return failed_result(self.match, reason, seat=seat, tick=tick, recording=path, play_hash=played)


class Lockstep:
    """Plays matches together. Loaded agents are kept and reset for the next match."""

    def __init__(
        self,
        *,
        record: Path | None = None,
        agent_limit_s: float = AGENT_LIMIT_S,
        batch_size: int = BATCH_SIZE,
        load: AgentLoader = load_agent,
        heartbeat: Callable[[], None] = lambda: None,
    ) -> None:
        """`heartbeat` is called about twice a second while agents decide."""
        self._record = record
        self._batch_size = batch_size
        self._load = load
        self._heartbeat = heartbeat
        self._timer = DecisionTimer(agent_limit_s, heartbeat)
        self._free: dict[str, list[Agent]] = defaultdict(list)  # loaded agents without a seat
        self._again: list[Match] = []  # to be played on their own
        self._cpu_s = 0.0  # process time at the end of the last tick

    def play(self, matches: Iterable[Match]) -> Iterator[MatchResult]:
        """Yield results as matches end. Raises RecordingError when a recording cannot be written."""
        playing: list[RunningMatch] = []
        try:
            yield from self._play(iter(matches), playing)
        except BaseException:  # Ctrl-C in a notebook, which keeps what was open then
            for live in playing:
                live.abandon()
            raise

    def _play(self, waiting: Iterator[Match], playing: list[RunningMatch]) -> Iterator[MatchResult]:
        self._cpu_s = time.process_time()
        while True:
            with self._timer.running(), noticing_ctrl_c():
                over = self._play_until_one_ends(waiting, playing)
            yield from over
            again, self._again = self._again, []
            for match in again:
                yield from self._play_alone(match)
            if not (playing or over or again):
                return

    def _play_alone(self, match: Match) -> Iterator[MatchResult]:
        """Play a match from its start, with new agents and none beside it."""
        limit_s = self._timer.limit_s
        alone = Lockstep(
            record=self._record, agent_limit_s=limit_s, batch_size=1, load=self._load, heartbeat=self._heartbeat
        )
        yield from alone.play([match])
        self._cpu_s = time.process_time()  # the matches that go on did not spend it

    def _play_until_one_ends(self, waiting: Iterator[Match], playing: list[RunningMatch]) -> list[MatchResult]:
        """Play until at least one match is over; return no results when none is left."""
        while True:
            failed, begun = self._begin_many(islice(waiting, self._room(playing)))
            playing += begun
            over = [*failed, *self._tick(playing)]
            if over or not playing:
                return over

    def _room(self, playing: list[RunningMatch]) -> int:
        """How many more matches may begin."""
        batched = bool(playing) and all(seat.group is not None for live in playing for seat in live.seats)
        return max((self._batch_size if batched else min(SMALL_BATCH, self._batch_size)) - len(playing), 0)

    def _begin_many(self, matches: Iterable[Match]) -> tuple[list[MatchResult], list[RunningMatch]]:
        """(results of matches that could not begin, matches that began)"""
        failed, begun = [], []
        for match in matches:
            try:
                begun.append(self._begin(match))
            except AgentFault as fault:
                failed.append(failed_result(match, fault.reason, seat=fault.seat))
            except MapError as error:
                failed.append(failed_result(match, str(error)))
        return failed, begun

    def _begin(self, match: Match) -> RunningMatch:
        agents: list[Agent] = []
        for seat, agent_id in enumerate(match.seats):
            if self._free[agent_id]:
                agents.append(self._free[agent_id].pop())
            else:
                with attribute_agent_errors(seat, agent_id, self._timer, "its factory", LOADING_S):
                    agents.append(self._load(agent_id))
        return RunningMatch(match, agents, self._record, self._timer)

    def _tick(self, playing: list[RunningMatch]) -> list[MatchResult]:
        """Advance every match by one tick; remove those that ended from `playing` and return their results."""
        deciding = [(live, seat) for live in playing for seat in live.seats if not seat.rows]
        decide([seat for _, seat in deciding], self._timer)
        if self._record is not None:
            for live, seat in deciding:
                live.keep_decision(seat)
        self._set_aside(playing)
        ended = [result for live in playing if (result := self._advance(live)) is not None]
        now = time.process_time()
        share, self._cpu_s = (now - self._cpu_s) / max(len(playing), 1), now
        for live in playing:
            live.cpu_s += share
        if ended:
            over = {result.match for result in ended}
            playing[:] = [live for live in playing if live.match not in over]
        return ended

    def _set_aside(self, playing: list[RunningMatch]) -> None:
        """Take out the matches whose agents failed in one call with those of others, to play each on its own."""
        if len(playing) == 1:
            return
        for live in [live for live in playing if any(seat.failed_together for seat in live.seats)]:
            live.abandon()
            playing.remove(live)
            self._again.append(live.match)

    def _advance(self, live: RunningMatch) -> MatchResult | None:
        for seat in live.seats:
            if seat.fault is not None:
                return live.fail(seat.fault.seat, seat.fault.reason)
        try:
            live.advance()
            if not live.over:
                return None
            live.take_counts(self._timer)
        except WorldError as error:
            return live.fail(-1, str(error))
        except AgentFault as fault:
            return live.fail(fault.seat, fault.reason)
        for seat in live.seats:  # agents without a fault are kept
            self._free[seat.agent_id].append(seat.agent)
        return live.result()
