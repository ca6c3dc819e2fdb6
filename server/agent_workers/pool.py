"""Agent seats and the workers that decide for them: which worker has time for one more, and which message is whose."""

import asyncio
import contextlib
import itertools
import time
from collections.abc import Callable, Iterator
from typing import Protocol

from movingout.agents.catalogue import agent_card
from movingout.agents.errors import AgentsBusyError
from movingout.agents.worker.heartbeat import Activity
from movingout.agents.worker.messages import Close, FromWorker, Open
from movingout.agents.worker.thread_budget import MOST_CORES
from movingout.maps import MapSpec
from movingout.server.agent_workers.agent_seat import AgentSeat
from movingout.server.agent_workers.capacity import AgentCosts, LateDecisions, cost_name, per_worker
from movingout.server.agent_workers.process import AgentProcess, Worker
from movingout.server.agent_workers.stopped_agents import StoppedAgents
from movingout.world.constants import TICK_SECONDS


class SeatAtWorker(Protocol):
    """A seat as its worker's pool sees it."""

    key: int
    agent_id: str
    cost_name: str
    failed: str

    def give_up(self, reason: str) -> None:
        """Ask the agent no more."""

    def begin(self) -> None:
        """The worker has just connected."""

    def take(self, message: FromWorker) -> None: ...

    def worker_lost(self, guilty: bool) -> None: ...


class AgentPool:
    """Worker processes for agents, and the seats they serve. Needs a running event loop."""

    def __init__(
        self,
        workers: int = 1,
        clock: Callable[[], float] = time.monotonic,
        costs: AgentCosts | None = None,
        first_key: int = 1,
        thread_cores: float = MOST_CORES,
        slow_agents: bool = False,
    ) -> None:
        self._clock = clock
        self.costs = costs or AgentCosts()
        self.decisions = 0
        self.missed = 0
        self._most = per_worker(workers)
        self._thread_cores = thread_cores
        self._slow_agents = slow_agents
        self._stopped = StoppedAgents(clock)
        self._late: dict[Worker, LateDecisions] = {}
        self._seats: dict[int, SeatAtWorker] = {}
        self._home: dict[int, Worker] = {}
        self._keys = itertools.count(first_key)
        self._limited = True
        self._seated_before = False
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
        worker = self._admitted(agent_id, cost_name(agent_id, map))
        key = next(self._keys)
        must_keep_up = self._limited and not (self._seated_before or self._slow_agents)
        opening = Open(
            key=key, agent_id=agent_id, map=map, seat=seat, seed=seed, ticks=ticks, must_keep_up=must_keep_up
        )
        taken = AgentSeat(pool=self, key=key, worker=worker, opening=opening, clock=self._clock)
        self._seats[key] = taken
        self._home[key] = worker
        if why := self._stopped.why(agent_id):
            taken.give_up(why)
        elif worker.connected:
            taken.begin()
        return taken

    @contextlib.contextmanager
    def without_limit(self) -> Iterator[None]:
        """Within it no agent is refused for want of capacity or as too slow: those of rooms that come back had a place.

        For a block that does not await.
        """
        self._limited = False
        try:
            yield
        finally:
            self._limited = True

    @contextlib.contextmanager
    def already_seated(self) -> Iterator[None]:
        """Within it no agent is refused as too slow: those of another node's rooms had begun. Places count.

        For a block that does not await.
        """
        self._seated_before = True
        try:
            yield
        finally:
            self._seated_before = False

    def _least_busy(self) -> "Worker":
        return min(self._workers, key=self.load)

    def _admitted(self, agent_id: str, cost_name: str) -> "Worker":
        """The worker that takes one more seat. Raises AgentsBusyError."""
        worker = self._least_busy()
        load = self.load(worker) + self.costs.of(cost_name)
        if self._limited and self._seats_of(worker):  # a worker without seats always takes one
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
        return sum(self.costs.of(seat.cost_name) for seat in self._seats_of(worker))

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

    def note_cost(self, cost_name: str, decision_ms: float, execute: int) -> None:
        """Called by a seat with the cost of a decision and the number of ticks it covers."""
        self.costs.note(cost_name, decision_ms / 1e3 / (TICK_SECONDS * execute))

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
