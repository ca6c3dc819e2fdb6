"""Agent seats: ask a worker process for actions, play its chunks, and stay neutral while it does not answer.

Nothing here blocks: `observe` sends a request to the worker, `answer` reads what has come back.
"""

import asyncio
import itertools
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from movingout.agents.action_chunk import NEUTRAL, world_action
from movingout.agents.base import ActionChunk
from movingout.agents.catalogue import agent_card, unseen_map
from movingout.agents.decision_trace import shown_part
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
    ToWorker,
    answered_chunk,
    observe_message,
)
from movingout.agents.worker.thread_budget import MOST_CORES
from movingout.maps import MapSpec
from movingout.server.agent_workers.capacity import AgentCosts, LateDecisions, per_worker
from movingout.server.agent_workers.process import AgentProcess
from movingout.server.agent_workers.stopped_agents import StoppedAgents
from movingout.world.constants import TICK_SECONDS
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


class Worker(Protocol):
    """Where seats are decided for: a worker process, or a service that has several."""

    pid: int

    @property
    def restarts(self) -> int: ...

    @property
    def overruns(self) -> int:
        """How often an agent's threads had to be ended with the worker."""

    @property
    def connected(self) -> bool: ...

    def start(self) -> None: ...

    def send(self, message: ToWorker) -> None:
        """Dropped while it is not connected."""

    def faults(self) -> Iterator[str]: ...

    async def close(self) -> None: ...


class SeatAtWorker(Protocol):
    """A seat as its worker's pool sees it."""

    key: int
    agent_id: str
    failed: str

    def give_up(self, reason: str) -> None:
        """Ask the agent no more."""

    def begin(self) -> None:
        """The worker has just connected."""

    def take(self, message: FromWorker) -> None: ...

    def worker_lost(self, guilty: bool) -> None: ...


class AgentSeat:
    """One agent in one seat for one episode. Created by `AgentPool.open`."""

    def __init__(self, pool: "AgentPool", key: int, worker: Worker, opening: Open, clock: Callable[[], float]) -> None:
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
                self._pool.costs.measured(self.agent_id, message.share)
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
        self._pool.note_cost(self.agent_id, message.decision_ms, message.execute)

    def _take_failure(self, message: Failed) -> None:
        self.failures += 1
        self._asked = None
        self._problem = message.reason
        if message.fatal:
            self.give_up(message.reason)


class AgentPool:
    """Worker processes for agents, and the seats they serve. Needs a running event loop."""

    def __init__(
        self,
        workers: int = 1,
        clock: Callable[[], float] = time.monotonic,
        costs: AgentCosts | None = None,
        first_key: int = 1,
        thread_cores: float = MOST_CORES,
    ) -> None:
        self._clock = clock
        self.costs = costs or AgentCosts()
        self.decisions = 0
        self.missed = 0
        self._most = per_worker(workers)
        self._thread_cores = thread_cores
        self._stopped = StoppedAgents(clock)
        self._late: dict[Worker, LateDecisions] = {}
        self._seats: dict[int, SeatAtWorker] = {}
        self._home: dict[int, Worker] = {}
        self._keys = itertools.count(first_key)
        self._workers: list[Worker] = []
        for _ in range(workers):
            worker = self._make_worker()
            self._late[worker] = LateDecisions(clock)
            self._workers.append(worker)

    def _make_worker(self) -> "Worker":
        def ready() -> None:
            for seat in self._seats_of(worker):
                seat.begin()

        def lost(activity: Activity) -> None:
            seat = None if activity.key is None else self._seats.get(activity.key)
            if activity.phase == "overrun" and seat is not None:
                self._stopped.stop(seat.agent_id, seat.failed)
            for seat in self._seats_of(worker):
                seat.worker_lost(guilty=activity.phase != "idle" and seat.key == activity.key)

        worker = AgentProcess(self._dispatch, ready, lost, self._thread_cores)
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
        worker = self._admitted(agent_id)
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
        if why := self._stopped.why(agent_id):
            taken.give_up(why)
        elif worker.connected:
            taken.begin()
        return taken

    def _admitted(self, agent_id: str) -> "Worker":
        """The worker that takes one more seat. Raises AgentsBusyError."""
        worker = min(self._workers, key=self.load)
        load = self.load(worker) + self.costs.of(agent_id)
        if self._seats_of(worker):  # a worker without seats always takes one
            if load > self._most:
                raise AgentsBusyError(
                    f"no room for one more {agent_id!r}: one agent process would be busy {load:.0%} of the time, and "
                    f"at most {self._most:.0%} is safe; try again when a game has ended, or start the server with more "
                    "--agent-workers"
                )
            if self._late[worker].too_many():
                raise AgentsBusyError(
                    f"no room for one more {agent_id!r}: the agents that play already decide too late on this machine"
                )
        return worker

    def _left(self, worker: "Worker") -> float:
        """The share of a core that one more agent may need of a worker that has seats."""
        return 0.0 if self._late[worker].too_many() else self._most - self.load(worker)

    def load(self, worker: "Worker") -> float:
        """Share of a core that the seats of `worker` use, as measured so far."""
        return sum(self.costs.of(seat.agent_id) for seat in self._seats_of(worker))

    @property
    def connected(self) -> bool:
        """Whether agents can be asked: some worker is up, or there are to be none."""
        return not self._workers or any(worker.connected for worker in self._workers)

    @property
    def capacity(self) -> float:
        """Share of a core that all seats together may use."""
        return self._most * len(self._workers)

    def faults(self) -> Iterator[str]:
        """What does not work and will not by itself, in English."""
        for worker in self._workers:
            yield from worker.faults()

    def report(self) -> list[dict[str, float]]:
        """One row per worker for the admin page: pid, restarts, overruns, seats, load."""
        return [
            {
                "pid": worker.pid,
                "restarts": worker.restarts,
                "overruns": worker.overruns,
                "seats": len(self._seats_of(worker)),
                "load": round(self.load(worker), 4),
            }
            for worker in self._workers
        ]

    def forget(self, seat: "SeatAtWorker") -> None:
        """Called by `AgentSeat.close`."""
        if self._seats.pop(seat.key, None) is not None:
            self._home.pop(seat.key).send(Close(seat.key))

    def note_cost(self, agent_id: str, decision_ms: float, execute: int) -> None:
        """Called by a seat with the cost of a decision and the number of ticks it covers."""
        self.costs.note(agent_id, decision_ms / 1e3 / (TICK_SECONDS * execute))

    def note_decision(self, seat: "SeatAtWorker", missed: bool) -> None:
        """Called by a seat in each tick for which a decision was due."""
        self.decisions += 1
        self.missed += missed
        home = self._home.get(seat.key)
        if home is not None:
            self._late[home].note(missed)

    def _seats_of(self, worker: "Worker") -> "list[SeatAtWorker]":
        return [seat for key, seat in self._seats.items() if self._home[key] is worker]

    def _dispatch(self, message: FromWorker) -> None:
        seat = self._seats.get(message.key)
        if seat is not None:
            seat.take(message)
