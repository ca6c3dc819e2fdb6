"""Agents for the rooms of one process, from the agent service that all processes of a server share."""

import asyncio
import contextlib
import logging
import secrets
import socket
from collections.abc import Iterator

import msgspec

from movingout.agents.errors import AgentsBusyError
from movingout.agents.worker.messages import Close, FrameBuffer, ToWorker, frame
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.agent_workers.process import Worker
from movingout.server.processes.agent_messages import Free, Lost, read_from_service

log = logging.getLogger(__name__)


class SharedAgents(AgentPool):
    """A pool whose only worker is the service; `join` connects to it, again whenever the front has started another."""

    def __init__(self, slow_agents: bool = False) -> None:
        self._shares_left = [0.0]  # by worker, as the service said last, less what was admitted since
        self._heard = asyncio.Event()
        first_key = secrets.randbits(38) << 24  # no two processes may use the same keys
        super().__init__(workers=1, first_key=first_key, slow_agents=slow_agents)

    def _make_worker(self) -> Worker:
        self._link = _ServiceLink(self)
        return self._link

    def _admitted(self, agent_id: str, cost_name: str) -> Worker:
        share = self.costs.of(cost_name)
        self._shares_left.sort()
        if self._limited and share > self._shares_left[-1]:
            raise AgentsBusyError(f"no room for one more {agent_id!r}: the agents of this server are all at work")
        self._shares_left[-1] = min(self._shares_left[-1], self._most) - share
        return self._link

    def join(self, link: socket.socket) -> None:
        """Use this connection to the service from now on."""
        self._link.use(link)

    async def joined(self, within_s: float) -> None:
        """Wait until the service has said what it can take."""
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._heard.wait(), within_s)

    def report(self) -> list[dict[str, float]]:
        """Nothing: the service reports its workers itself."""
        return []

    def heard(self, body: bytes) -> None:
        match message := read_from_service(body):
            case Free(left, most, costs):
                self._shares_left, self._most = [*left] or [0.0], most
                self.costs.take_over(costs)
                self._heard.set()
            case Lost(key, guilty):
                seat = self._seats.get(key)
                if seat is not None:
                    seat.worker_lost(guilty)
                    if seat.failed:
                        self._link.send(Close(key))
            case _:
                self._dispatch(message)

    def service_joined(self) -> None:
        for seat in self._seats.values():
            seat.begin()

    def service_lost(self) -> None:
        self._shares_left = [0.0]
        for seat in self._seats.values():
            seat.worker_lost(guilty=False)


class _ServiceLink:
    """The service as a pool sees it: a worker."""

    pid = 0
    restarts = overruns = 0

    def faults(self) -> Iterator[str]:
        """The front watches over the service."""
        return iter(())

    def __init__(self, pool: SharedAgents) -> None:
        self._pool = pool
        self._writer: asyncio.StreamWriter | None = None
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """The service is started by the front."""

    def use(self, link: socket.socket) -> None:
        if self._task is not None:
            self._task.cancel()
        self._task = asyncio.create_task(self._listen(link))

    @property
    def connected(self) -> bool:
        return self._writer is not None

    def send(self, message: ToWorker) -> None:
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(frame(message))

    async def close(self) -> None:
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task

    async def _listen(self, link: socket.socket) -> None:
        reader, self._writer = await asyncio.open_connection(sock=link)
        writer, buffer = self._writer, FrameBuffer()
        self._pool.service_joined()
        try:
            while data := await reader.read(1 << 16):
                for body in buffer.feed(data):
                    self._pool.heard(body)
        except (ConnectionError, msgspec.MsgspecError) as error:
            log.warning("the agent service: %s", error)
        finally:
            writer.close()
            if self._writer is writer:
                self._writer = None
            self._pool.service_lost()
