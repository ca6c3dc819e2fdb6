"""Agent seats: ask a worker process for actions, play its chunks, and stay neutral while it does not answer.

Nothing here blocks: `observe` sends a request to the worker, `answer` reads what has come back.
"""

import asyncio
import itertools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from movingout.agents.action_chunk import NEUTRAL, world_action
from movingout.agents.base import ActionChunk
from movingout.agents.catalogue import agent_card, unseen_map
from movingout.agents.errors import AgentsBusyError
from movingout.agents.worker.heartbeat import Activity
from movingout.agents.worker.messages import (
    Answer,
    Close,
    Failed,
    FromWorker,
    Open,
    Opened,
    Skipped,
    answered_chunk,
    observe_message,
)
from movingout.maps import MapSpec
from movingout.server.agent_workers.process import AgentProcess
from movingout.world.constants import TICK_SECONDS
from movingout.world.ping import HelpPing
from movingout.world.state import Floats, WorldState

MAX_LOAD = 0.8  # share of one core that a worker's seats may use
FIRST_GUESS_MS = 3.0  # assumed cost of a decision until one is measured
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


class AgentSeat:
    """One agent in one seat for one episode. Created by `AgentPool.open`."""

    def __init__(
        self, pool: "AgentPool", key: int, worker: AgentProcess, opening: Open, clock: Callable[[], float]
    ) -> None:
        self._pool = pool
        self._clock = clock
        self._worker = worker
        self._opening = opening
        self.key = key
        self.agent_id = opening.agent_id
        self.unseen = unseen_map(opening.agent_id, opening.map.name)
        self.ready = False  # loaded and warm
        self.failed = ""  # why it is no longer asked; empty while it plays
        self.decisions = 0
        self.missed = 0
        self.failures = 0
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
        if guilty:
            self.strikes += 1
            self.failures += 1
            self._problem = "the agent's process died or hung"
            if self.strikes >= STRIKES:
                self._give_up(f"the agent's process died or hung {self.strikes} times")

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
        if self._asked is not None:
            self._latency_ms = (self._clock() - self._asked.asked) * 1e3
        self._asked = None
        self._pool.note_cost(self.agent_id, message.decision_ms, message.execute)

    def _take_failure(self, message: Failed) -> None:
        self.failures += 1
        self._asked = None
        self._problem = message.reason
        if message.fatal:
            self._give_up(message.reason)

    def _give_up(self, reason: str) -> None:
        self.failed = reason
        self._waiting = None
        self._execute = 0


class AgentPool:
    """Worker processes for agents, and the seats they serve. Needs a running event loop."""

    def __init__(self, workers: int = 1, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seats: dict[int, AgentSeat] = {}
        self._home: dict[int, AgentProcess] = {}
        self._costs: dict[str, float] = {}  # share of a core per seat, by agent id
        self._keys = itertools.count(1)
        self._workers: list[AgentProcess] = []
        for _ in range(workers):
            self._workers.append(self._make_worker())

    def _make_worker(self) -> AgentProcess:
        def ready() -> None:
            for seat in self._seats_of(worker):
                seat.begin()

        def lost(activity: Activity) -> None:
            for seat in self._seats_of(worker):
                seat.worker_lost(guilty=activity.phase != "idle" and seat.key == activity.key)

        worker = AgentProcess(self._dispatch, ready, lost)
        return worker

    async def start(self) -> None:
        """Start the workers; returns at once, they become ready on their own."""
        for worker in self._workers:
            worker.start()

    async def close(self) -> None:
        """Stop the workers."""
        await asyncio.gather(*(worker.close() for worker in self._workers))

    def open(self, agent_id: str, map: MapSpec, seat: int, seed: int, ticks: int) -> AgentSeat:
        """Seat an agent for one episode; it loads in the background (`AgentSeat.ready`).

        Raises AgentError for an unknown id and AgentsBusyError when the workers have no capacity left. An agent that
        cannot be loaded reports it later, in `AgentSeat.failed`.
        """
        agent_card(agent_id)
        worker = min(self._workers, key=self.load)
        load = self.load(worker) + self._cost(agent_id)
        if load > MAX_LOAD and self._seats_of(worker):  # a worker without seats always takes one
            raise AgentsBusyError(
                f"no room for one more {agent_id!r}: the agents here would need {load:.0%} of a core each tick; "
                "close a room or start the server with more agent workers"
            )
        key = next(self._keys)
        taken = AgentSeat(
            pool=self,
            key=key,
            worker=worker,
            opening=Open(key=key, agent_id=agent_id, map=map, seat=seat, seed=seed, ticks=ticks),
            clock=self._clock,
        )
        self._seats[key] = taken
        self._home[key] = worker
        if worker.connected:
            taken.begin()
        return taken

    def load(self, worker: AgentProcess) -> float:
        """Share of a core that the seats of `worker` use, as measured so far."""
        return sum(self._cost(seat.agent_id) for seat in self._seats_of(worker))

    def report(self) -> list[dict[str, float]]:
        """One row per worker for the admin page: pid, restarts, seats, load."""
        return [
            {
                "pid": worker.pid,
                "restarts": worker.restarts,
                "seats": len(self._seats_of(worker)),
                "load": round(self.load(worker), 4),
            }
            for worker in self._workers
        ]

    def forget(self, seat: AgentSeat) -> None:
        """Called by `AgentSeat.close`."""
        if self._seats.pop(seat.key, None) is not None:
            self._home.pop(seat.key).send(Close(seat.key))

    def note_cost(self, agent_id: str, decision_ms: float, execute: int) -> None:
        """Called by a seat with the cost of a decision and the number of ticks it covers.

        An exponential average with weight 1/20, for the first decision too: it includes one-off planning, and must not
        make the pool refuse seats.
        """
        cost = decision_ms / 1e3 / (TICK_SECONDS * execute)
        self._costs[agent_id] = 0.95 * self._cost(agent_id) + 0.05 * cost

    def _cost(self, agent_id: str) -> float:
        return self._costs.get(agent_id, FIRST_GUESS_MS / 1e3 / TICK_SECONDS)

    def _seats_of(self, worker: AgentProcess) -> list[AgentSeat]:
        return [seat for key, seat in self._seats.items() if self._home[key] is worker]

    def _dispatch(self, message: FromWorker) -> None:
        seat = self._seats.get(message.key)
        if seat is not None:
            seat.take(message)
