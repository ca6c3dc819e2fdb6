"""An agent in a seat of a room: ask its worker for actions, play its chunks, and stay neutral while none has come.

Nothing here blocks: `observe` sends a request to the worker, `answer` reads what has come back.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import msgspec
import numpy as np

from movingout.agents.action_chunk import NEUTRAL, world_action
from movingout.agents.base import ActionChunk
from movingout.agents.catalogue import unseen_map
from movingout.agents.decision_trace import shown_part
from movingout.agents.worker.messages import (
    Answer,
    Failed,
    FromWorker,
    Open,
    Opened,
    Skipped,
    answered_chunk,
    observe_message,
)
from movingout.server.agent_workers.capacity import AgentCosts, cost_name
from movingout.server.agent_workers.process import Worker
from movingout.world.ping import HelpPing
from movingout.world.state import Floats, WorldState

STRIKES = 3  # after losing the worker this often, a seat is not asked again


@dataclass(frozen=True, slots=True)
class AgentAnswer:
    """What an agent does in one tick."""

    action: Floats  # (3,) for World.step: distance, heading [rad], toggle
    missed: bool  # a decision was due and had not arrived
    latency_ms: float  # from request to answer; -1 while a chunk continues
    detail: Mapping[str, object] = field(default_factory=dict)
    problem: str = ""  # a sentence if the agent has failed since the last answer


@dataclass(frozen=True, slots=True)
class _Question:
    state: WorldState
    tick: int
    deadline: float
    pings: tuple[HelpPing, ...]
    asked: float


def admitted(opening: Open) -> Open:
    """For the same seat at another worker: who has sat down is not refused in the middle of a round."""
    return msgspec.structs.replace(opening, must_keep_up=False)


class SeatPool(Protocol):
    """What a seat needs of the pool that made it."""

    @property
    def costs(self) -> AgentCosts: ...

    def forget(self, seat: "AgentSeat") -> None:
        """The episode is over."""

    def note_cost(self, cost_name: str, decision_ms: float, execute: int) -> None:
        """What a decision cost, and the number of ticks it covers."""

    def note_decision(self, seat: "AgentSeat", missed: bool) -> None:
        """A decision was due in this tick."""


class AgentSeat:
    """One agent in one seat for one episode. Created by `AgentPool.open`."""

    def __init__(self, pool: SeatPool, key: int, worker: Worker, opening: Open, clock: Callable[[], float]) -> None:
        self._pool = pool
        self._clock = clock
        self._worker = worker
        self._opening = opening
        self.key = key
        self.agent_id = opening.agent_id
        self.cost_name = cost_name(opening.agent_id, opening.map)
        self.unseen = unseen_map(opening.agent_id, opening.map.name)
        self.ready = False  # loaded and warm
        self.failed = ""  # why it is no longer asked; empty while it plays
        self.slow = False  # whether that is why
        self.decisions = 0
        self.missed = 0
        self.failures = 0
        self.has_weighed = False  # some decision had something to show to spectators
        self.strikes = 0
        self._problem = ""
        self._chunk: ActionChunk = np.empty((0, 4))
        self._chunk_tick = -1
        self._execute = 0
        self._detail: Mapping[str, object] = {}
        self._latency_ms = -1.0
        self._due = -1  # the tick of the newest request
        self._asked: _Question | None = None
        self._waiting: _Question | None = None

    def observe(self, state: WorldState, tick: int, deadline: float, pings: tuple[HelpPing, ...] = ()) -> None:
        """Request the action of `tick`, which starts from `state`; an answer after `deadline` is useless.

        `deadline` is in seconds of the machine's monotonic clock, which the worker reads too.
        No request is made while the last chunk is still being played.
        """
        if self.failed or 0 <= tick - self._chunk_tick < self._execute:
            return
        self._due = tick
        self._waiting = _Question(state, tick, deadline, pings, self._clock())
        self._ask()

    def answer(self, tick: int) -> AgentAnswer:
        """The action for `tick`: a row of the new chunk, a later row of an older one, or neutral."""
        row = tick - self._chunk_tick
        missed = self._due == tick and self._chunk_tick != tick
        self.missed += missed
        if self._due == tick:
            self._pool.note_decision(self, missed)
        covered = 0 <= row < len(self._chunk)
        action = np.array(world_action(self._chunk[row]) if covered else NEUTRAL)
        fresh = self._chunk_tick == tick and covered
        problem, self._problem = self._problem, ""
        return AgentAnswer(
            action=action,
            missed=missed,
            latency_ms=self._latency_ms if fresh else -1.0,
            detail=self._detail if fresh else {},
            problem=problem,
        )

    @property
    def decision_trace(self) -> tuple[int, Mapping[str, object]]:
        """Tick of the newest answer (-1 before the first) and the agent's explanation of it."""
        return self._chunk_tick, self._detail

    def close(self) -> None:
        """The episode is over."""
        self._pool.forget(self)

    # ---- called by the pool -----------------------------------------------------------------------------------

    def give_up(self, reason: str) -> None:
        """Ask the agent no more; its seat stays neutral."""
        self.failed = reason
        self._waiting = None
        self._execute = 0

    def begin(self) -> None:
        """Open the episode at a worker that has just connected."""
        self.ready = False
        self._asked = None
        if not self.failed:
            self._worker.send(self._opening)

    def take(self, message: FromWorker) -> None:
        """Handle a message from the worker about this seat."""
        match message:
            case Opened():
                self.ready = True
                self._opening = admitted(self._opening)
                self._pool.costs.measured(self.cost_name, message.share)
            case Answer():
                self._take_answer(message)
            case Skipped():
                self._asked = None
            case Failed():
                self._take_failure(message)
        self._ask()

    def worker_lost(self, guilty: bool) -> None:
        """The worker is gone; `guilty` if it was deciding for this seat."""
        self.ready = False
        self._asked = None
        if guilty and not self.failed:
            self.strikes += 1
            self.failures += 1
            self._problem = "the agent's process died or hung"
            if self.strikes >= STRIKES:
                self.give_up(f"the agent's process died or hung {self.strikes} times")

    def _ask(self) -> None:
        if self._waiting is None or self._asked is not None or not self.ready or self.failed:
            return
        self._asked, self._waiting = self._waiting, None
        asked = self._asked
        self._worker.send(observe_message(self.key, asked.tick, asked.deadline, asked.state, asked.pings))

    def _take_answer(self, message: Answer) -> None:
        self.decisions += 1
        self._chunk = answered_chunk(message)
        self._chunk_tick, self._execute, self._detail = message.tick, message.execute, message.detail
        self.has_weighed = self.has_weighed or bool(shown_part(message.detail))
        if self._asked is not None:
            self._latency_ms = (self._clock() - self._asked.asked) * 1e3
        self._asked = None
        self._pool.note_cost(self.cost_name, message.decision_ms, message.execute)

    def _take_failure(self, message: Failed) -> None:
        self.failures += 1
        self._asked = None
        self._problem = message.reason
        if message.fatal:
            self.slow = message.slow
            self.give_up(message.reason)
