"""The process that has the agents of all rooms: it starts their workers, admits seats, and passes messages on.

Started by `agent_link.py`, which passes two descriptors to `main`.
"""

import asyncio
import itertools
import logging
import signal
import socket
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import msgspec

from movingout.agents.errors import AgentError
from movingout.agents.worker.messages import (
    Answer,
    Close,
    Failed,
    FrameBuffer,
    FromWorker,
    Observe,
    Open,
    Opened,
    Skipped,
    ToWorker,
    frame,
    read_to_worker,
)
from movingout.server.agent_workers.agent_seat import admitted
from movingout.server.agent_workers.agent_use import AgentUse, agent_use
from movingout.server.agent_workers.capacity import COSTS_S, AgentCosts, cost_name
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.agent_workers.process import Worker
from movingout.server.background import BackgroundWork
from movingout.server.monitoring.logs import log_to
from movingout.server.monitoring.status import process_report
from movingout.server.processes.agent_messages import Free, Lost
from movingout.server.processes.channel import Channel, first_message

log = logging.getLogger(__name__)

NEWS_S = 0.5
PLENTY = 1e6  # share of a core: a worker without seats takes any agent


@dataclass(frozen=True)
class StartAgents:
    """The first message to the process."""

    workers: int
    costs: Path
    log_format: str
    thread_cores: float


class ServedSeat:
    """A seat of a room in another process."""

    def __init__(self, pool: "ServicePool", worker: Worker, opening: Open, rooms: "RoomsLink") -> None:
        self.key = opening.key
        self.agent_id = opening.agent_id
        self.cost_name = cost_name(opening.agent_id, opening.map)
        self._pool = pool
        self._worker = worker
        self._opening = opening
        self._rooms = rooms
        self._deadline = 0.0
        self.failed = ""

    def give_up(self, reason: str) -> None:
        self.failed = reason

    def begin(self) -> None:
        if not self.failed:
            self._worker.send(self._opening)

    def ask(self, question: Observe) -> None:
        self._deadline = question.deadline
        self._worker.send(question)

    def take(self, message: FromWorker) -> None:
        """Pass on what the worker says, and learn from it."""
        match message:
            case Opened():
                self._opening = admitted(self._opening)
                self._pool.costs.measured(self.cost_name, message.share)
            case Answer():
                self._pool.note_cost(self.cost_name, message.decision_ms, message.execute)
                self._pool.note_decision(self, asyncio.get_running_loop().time() > self._deadline)
            case Skipped():
                self._pool.note_decision(self, missed=True)
            case Failed(fatal=True):
                self.give_up(message.reason)
        self._rooms.send(message)

    def worker_lost(self, guilty: bool) -> None:
        self._rooms.send(Lost(self.key, guilty))


class ServicePool(AgentPool):
    """The workers, and the seats of all processes."""

    def open_remote(self, opening: Open, rooms: "RoomsLink") -> None:
        """Seat an agent that its process has admitted, which knows what is free or played before. Raises AgentError."""
        if why := self._stopped.why(opening.agent_id):
            raise AgentError(why)
        worker = self._least_busy()
        seat = ServedSeat(self, worker, opening, rooms)
        self._seats[opening.key], self._home[opening.key] = seat, worker
        if worker.connected:
            seat.begin()

    def seat(self, key: int) -> ServedSeat | None:
        found = self._seats.get(key)
        return found if isinstance(found, ServedSeat) else None

    def free(self) -> Free:
        """What each worker can take, and what agents were measured to need."""
        left = (self._left(one) if self._seats_of(one) else PLENTY for one in self._workers)
        return Free(tuple(left), self._most, self.costs.known())


class RoomsLink:
    """The connection to one process with rooms; `tell_all` tells every process at once what it has taken or left."""

    def __init__(self, pool: ServicePool, tell_all: Callable[[], None]) -> None:
        self._pool = pool
        self._tell_all = tell_all
        self._writer: asyncio.StreamWriter | None = None
        self._keys: set[int] = set()

    async def serve(self, link: socket.socket) -> None:
        """Until the other end closes; its seats are then free."""
        reader, self._writer = await asyncio.open_connection(sock=link)
        buffer = FrameBuffer()
        try:
            self.tell_free()
            while data := await reader.read(1 << 16):
                for body in buffer.feed(data):
                    self._take(read_to_worker(body))
        except (ConnectionError, msgspec.MsgspecError) as error:
            log.debug("a process with rooms has ended: %s", error)
        finally:
            self._writer.close()
            for key in list(self._keys):
                self._close(key)
            self._tell_all()

    def send(self, message: FromWorker | Lost | Free) -> None:
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(frame(message))

    def tell_free(self) -> None:
        self.send(self._pool.free())

    def _take(self, message: ToWorker) -> None:
        match message:
            case Open():
                self._open(message)
                self._tell_all()
            case Observe():
                seat = self._pool.seat(message.key)
                if seat is not None:
                    seat.ask(message)
            case Close():
                self._close(message.key)
                self._tell_all()

    def _open(self, message: Open) -> None:
        try:
            self._pool.open_remote(message, self)
            self._keys.add(message.key)
        except AgentError as error:
            self.send(Failed(message.key, -1, str(error), fatal=True))

    def _close(self, key: int) -> None:
        self._keys.discard(key)
        seat = self._pool.seat(key)
        if seat is not None:
            self._pool.forget(seat)


class AgentService:
    """The process."""

    def __init__(self, start: StartAgents) -> None:
        self.pool = ServicePool(start.workers, costs=AgentCosts(start.costs), thread_cores=start.thread_cores)
        self.background = BackgroundWork()
        self._links: dict[RoomsLink, asyncio.Task[None]] = {}

    def join(self, link: socket.socket) -> None:
        """Serve one more process with rooms."""
        rooms = RoomsLink(self.pool, self.tell_free)
        task = asyncio.create_task(rooms.serve(link))
        self._links[rooms] = task
        task.add_done_callback(lambda _: self._links.pop(rooms, None))

    def tell_free(self) -> None:
        """Processes admit seats by themselves, so that none may take for free what another has just taken."""
        for rooms in self._links:
            rooms.tell_free()

    def faults(self) -> tuple[str, ...]:
        return (*self.background.faults(), *self.pool.faults())

    async def keep_costs(self) -> None:
        await asyncio.to_thread(self.pool.costs.save)


def use(service: AgentService, wanted: Collection[str], taken: Collection[str]) -> AgentUse:
    return agent_use(service.pool, wanted, taken)


def report(service: AgentService) -> dict[str, Any]:
    return process_report() | {"agents": service.pool.report()}


class ServiceListener(Protocol):
    """The front."""

    def heard(self, faults: tuple[str, ...]) -> None:
        """The service lives; what does not work there."""


def heard(watcher: ServiceListener, faults: tuple[str, ...]) -> None:
    watcher.heard(faults)


async def _serve(control: socket.socket, handover: socket.socket, start: StartAgents) -> None:
    service = AgentService(start)
    background = service.background
    channel: Channel[AgentService, ServiceListener] = Channel(control, service)
    await channel.open()
    await service.pool.start()

    async def tell_news() -> None:
        channel.tell(heard, service.faults())

    async def tell_free() -> None:
        service.tell_free()

    background.repeat("telling the front", tell_news, NEWS_S)
    background.repeat("telling how many agents are possible", tell_free, NEWS_S)
    background.repeat("keeping the costs of agents", service.keep_costs, COSTS_S)
    loop = asyncio.get_running_loop()
    loop.add_reader(handover, lambda: _take_links(handover, service))
    try:
        await channel.serve()
    finally:
        loop.remove_reader(handover)
        await background.stop()
        await service.pool.close()
        service.pool.costs.save()


def _take_links(handover: socket.socket, service: AgentService) -> None:
    message, descriptors, _, _ = socket.recv_fds(handover, 64, 1)
    if not message:
        asyncio.get_running_loop().remove_reader(handover)
    for descriptor in descriptors:
        service.join(socket.socket(fileno=descriptor))


def main(arguments: list[str]) -> None:
    """Serve until the front ends."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1):  # the front's affair
        signal.signal(number, signal.SIG_IGN)
    control, handover = (socket.socket(fileno=int(each)) for each in itertools.islice(arguments, 2))
    start = first_message(control, StartAgents)
    log_to(form="json" if start.log_format == "json" else "text")
    handover.setblocking(False)
    asyncio.run(_serve(control, handover, start))
