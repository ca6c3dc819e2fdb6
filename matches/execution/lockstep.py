"""Many matches in one process, tick by tick together, so that agents of one kind are asked in one batch.

The numbers of a match depend on the match alone: neither on its company nor on the order. What an agent does wrong
loses its own match and no other.
"""

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Literal

import numpy as np

from movingout.agents.base import Agent, EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import Watcher
from movingout.agents.decision_trace import decision_trace
from movingout.maps.errors import MapError
from movingout.matches.execution.batched_decisions import ask
from movingout.matches.execution.decision_timeout import Stopwatch
from movingout.matches.execution.recorder import Recorder
from movingout.matches.execution.seat import AgentFault, Blaming, Seat
from movingout.matches.match import Match, MatchResult, lost
from movingout.world import World, WorldError
from movingout.world.metrics import EpisodeMetrics

AGENT_LIMIT_S = 20.0
COMPANY = 32  # matches that step together when all their agents answer in batches
FEW = 8  # others gain little from more company, and their results come sooner

Loader = Callable[[str], Agent]


class LiveMatch:
    """A match that is being played. Raises AgentFault when an agent cannot begin."""

    def __init__(self, match: Match, agents: Sequence[Agent], record: Path | None, stopwatch: Stopwatch) -> None:
        self.match = match
        the_map = match.world_map()
        self.world = World(the_map, record_sub_poses=False)
        self.state = self.world.state()
        self.metrics = EpisodeMetrics(the_map)
        self.cpu_s = 0.0
        self.seats: list[Seat] = []
        for seat, (agent, agent_id) in enumerate(zip(agents, match.seats, strict=True)):
            episode = EpisodeInfo(the_map, seat, match.seed, match.ticks)
            with Blaming(seat, agent_id, stopwatch, "reset()"):
                agent.reset(episode)
                if isinstance(agent, Watcher):
                    agent.watch(self.world)
                self.seats.append(Seat(agent, agent_id, episode, self.state))
        self.recorder = None if record is None else Recorder(record, match, self.state)

    @property
    def over(self) -> bool:
        return self.state.tick >= self.match.ticks or self.world.score() == 1.0

    def keep_decision(self, seat: Seat) -> None:
        """Record what the agent says about the answer it has just given."""
        if self.recorder is not None and (detail := decision_trace(seat.agent)):
            self.recorder.decision(seat.episode.seat, self.state.tick + 1, detail)

    def advance(self) -> None:
        """One tick with the next row of each seat. Raises WorldError when the physics lost its numbers."""
        actions = np.array([seat.next_action() for seat in self.seats])
        before = self.state
        self.world.step(actions)
        self.state = self.world.state()
        for seat in self.seats:
            seat.state = self.state
        self.metrics.update(before, actions, self.state)
        if self.recorder is not None:
            self.recorder.tick(actions, self.state, self.world.delivered().tolist())

    def result(self) -> MatchResult:
        """The result of a match that is over; ends its recording."""
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
        )

    def lose(self, seat: int, reason: str) -> MatchResult:
        """The result of a match that an agent has lost; ends its recording."""
        tick = self.state.tick
        path = "" if self.recorder is None else str(self.recorder.close("error", tick, seat, reason))
        return lost(self.match, reason, seat=seat, tick=tick, recording=path)


class Lockstep:
    """Plays matches together. Loaded agents are kept: the next match resets them."""

    def __init__(
        self,
        *,
        record: Path | None = None,
        agent_limit_s: float = AGENT_LIMIT_S,
        company: int = COMPANY,
        load: Loader = load_agent,
        beat: Callable[[], None] = lambda: None,
    ) -> None:
        """`beat` is called about twice a second while agents think: a sign of life."""
        self._record = record
        self._company = company
        self._load = load
        self._stopwatch = Stopwatch(agent_limit_s, beat)
        self._free: dict[str, list[Agent]] = defaultdict(list)  # loaded agents that sit nowhere
        self._cpu_s = 0.0  # the processor's clock when the last tick was over

    def play(self, matches: Iterable[Match]) -> Iterator[MatchResult]:
        """The results, in the order in which matches end. Raises RecordingError when a recording cannot be written."""
        waiting = iter(matches)
        playing: list[LiveMatch] = []
        self._cpu_s = time.process_time()
        while True:
            with self._stopwatch.running():
                over = self._until_some_end(waiting, playing)
            yield from over
            if not (playing or over):
                return

    def _until_some_end(self, waiting: Iterator[Match], playing: list[LiveMatch]) -> list[MatchResult]:
        """Play on until at least one match is over; no results when none is left."""
        while True:
            failed, begun = self._begin_some(islice(waiting, self._room(playing)))
            playing += begun
            over = [*failed, *self._tick(playing)]
            if over or not playing:
                return over

    def _room(self, playing: list[LiveMatch]) -> int:
        """How many matches more may begin."""
        batched = bool(playing) and all(seat.group is not None for live in playing for seat in live.seats)
        return max((self._company if batched else min(FEW, self._company)) - len(playing), 0)

    def _begin_some(self, matches: Iterable[Match]) -> tuple[list[MatchResult], list[LiveMatch]]:
        """Those that cannot begin, which are lost, and those that did."""
        failed, begun = [], []
        for match in matches:
            try:
                begun.append(self._begin(match))
            except AgentFault as fault:
                failed.append(lost(match, fault.reason, seat=fault.seat))
            except MapError as error:
                failed.append(lost(match, str(error)))
        return failed, begun

    def _begin(self, match: Match) -> LiveMatch:
        agents: list[Agent] = []
        for seat, agent_id in enumerate(match.seats):
            if self._free[agent_id]:
                agents.append(self._free[agent_id].pop())
            else:
                with Blaming(seat, agent_id, self._stopwatch, "its factory"):
                    agents.append(self._load(agent_id))
        return LiveMatch(match, agents, self._record, self._stopwatch)

    def _tick(self, playing: list[LiveMatch]) -> list[MatchResult]:
        """One tick of every match in the list, which keeps those that go on; the results of the others."""
        asked = [(live, seat) for live in playing for seat in live.seats if not seat.rows]
        ask([seat for _, seat in asked], self._stopwatch)
        if self._record is not None:
            for live, seat in asked:
                live.keep_decision(seat)
        ended = [result for live in playing if (result := self._advance(live)) is not None]
        now = time.process_time()
        share, self._cpu_s = (now - self._cpu_s) / max(len(playing), 1), now
        for live in playing:
            live.cpu_s += share
        if ended:
            over = {result.match for result in ended}
            playing[:] = [live for live in playing if live.match not in over]
        return ended

    def _advance(self, live: LiveMatch) -> MatchResult | None:
        for seat in live.seats:
            if seat.fault is not None:
                return live.lose(seat.fault.seat, seat.fault.reason)
        try:
            live.advance()
        except WorldError as error:
            return live.lose(-1, str(error))
        if not live.over:
            return None
        for seat in live.seats:  # agents that behaved are kept
            self._free[seat.agent_id].append(seat.agent)
        return live.result()
