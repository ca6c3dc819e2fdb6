"""The front's view of one process with rooms: started, watched, and replaced within moments when it dies or hangs."""

import asyncio
import contextlib
import logging
import os
import signal
import socket
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import psutil

from movingout.server.connection.admission import SocketNews, address_group
from movingout.server.connection.socket_counts import SocketCounts
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.processes.channel import Channel, ProcessGone
from movingout.server.processes.handover import HandingOver, closed_on_error, socket_pair
from movingout.server.processes.kept_process import STOP_S, KeptProcess
from movingout.server.processes.room_process import RoomProcess, Start
from movingout.server.processes.template import TemplateProcess
from movingout.server.rooms.room_view import PlayedRound

log = logging.getLogger(__name__)

SILENT_S = 10.0  # without a word: it hangs
WATCH_S = 0.5
START_S = 60.0
HOME_S = 5.0  # that a request waits for a process that is being replaced


class LinkOwner(Protocol):
    """What a link tells the front."""

    def arrived(self, address: str, link: "RoomLink") -> None:
        """A websocket over TLS has reached a process."""

    def flooded(self, address: str) -> None:
        """A websocket from this address was cut off."""

    def room_came_back(self, room_id: str, owner: str) -> None:
        """A new process has a room of the one before it, or of the last run."""

    def room_closed(self, room_id: str) -> None: ...

    def recorded(self, room_id: str, size: int) -> None: ...

    def round_over(self, room_id: str, played: PlayedRound) -> None: ...

    def finish_journal(self, journal: Path) -> None: ...

    def started(self, link: "RoomLink") -> None:
        """A process can be given connections; its rooms are not there yet."""

    def replaced(self) -> None:
        """A process has taken the place of another, whose journals may have been left behind."""


class RoomLink(KeptProcess):
    """One of several places for rooms, with whatever process fills it now. Use inside a running event loop."""

    def __init__(self, index: int, start: Start, template: TemplateProcess, front: LinkOwner) -> None:
        super().__init__(f"the rooms {index}")
        self.index = index
        self.rooms: set[str] = set()
        self.health = ProcessHealth()
        self.sockets = SocketCounts()
        self._start = start
        self._template = template
        self._front = front
        self._channel: Channel[RoomLink, RoomProcess] | None = None
        self._handing_over: HandingOver | None = None
        self._ready = asyncio.Event()
        self._heard = 0.0

    @property
    def has_started(self) -> bool:
        return self._handing_over is not None

    @property
    def is_ready(self) -> bool:
        return self._ready.is_set()

    async def ready(self, within_s: float | None = None) -> None:
        """Wait until rooms can be reached. Raises ProcessGone when that takes too long."""
        try:
            await asyncio.wait_for(self._ready.wait(), HOME_S if within_s is None else within_s)
        except TimeoutError:
            raise ProcessGone("the process of this room is being restarted; try again in a moment") from None

    async def call(self, work: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """The result of `work(room_process, ...)`. Raises what it raises, and ProcessGone."""
        await self.ready()
        assert self._channel is not None
        return await self._channel.call(work, *args, **kwargs)

    def tell(self, work: Callable[..., Any], *args: Any) -> None:
        if self._channel is not None:
            self._channel.tell(work, *args)

    def give(self, descriptor: int, message: bytes) -> None:
        """Hand a connection over. Raises ProcessGone."""
        if self._handing_over is None:
            raise ProcessGone("the process of this room has ended")
        self._handing_over.give(descriptor, message)

    def faults(self) -> Iterator[str]:
        """Those of the process where it is there, and its own."""
        yield from self.health.faults if self.is_ready else ()
        yield from super().faults()

    def terminate(self) -> None:
        """Ask the process to keep its rooms and end; another one takes its place."""
        self._kill(signal.SIGTERM)

    # ---- told by the process --------------------------------------------------------------------------------

    def became_ready(self, owners: dict[str, str]) -> None:
        for lost in self.rooms - owners.keys():
            self._front.room_closed(lost)
        for room_id, owner in owners.items():
            self._front.room_came_back(room_id, owner)
        self.rooms = set(owners)
        self._heard = time.monotonic()
        self.restart_record.seen()
        self._ready.set()
        if self.restarts:
            self._front.replaced()

    def leaving(self) -> None:
        """The process ends: whoever wants to reach its rooms waits for the next one."""
        self._ready.clear()

    def heard(self, health: ProcessHealth) -> None:
        self.health, self._heard = health, time.monotonic()
        self.restart_record.seen()

    def arrived(self, address: str) -> None:
        self._front.arrived(address, self)

    def socket_changed(self, news: SocketNews, address: str) -> None:
        group = address_group(address)
        match news:
            case "entered":
                self.sockets.entered(group)
            case "joined":
                self.sockets.joined(group)
            case "left":
                self.sockets.left(group)
            case "flooded":
                self._front.flooded(address)

    def room_closed(self, room_id: str) -> None:
        self.rooms.discard(room_id)
        self._front.room_closed(room_id)

    def recorded(self, room_id: str, size: int) -> None:
        self._front.recorded(room_id, size)

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        self._front.round_over(room_id, played)

    def finish_journal(self, journal: Path) -> None:
        self._front.finish_journal(journal)

    # ---- the life of a process ------------------------------------------------------------------------------

    async def _one_life(self) -> None:
        ours, theirs = socket.socketpair()
        giving, taking = socket_pair()
        with closed_on_error(ours, giving), theirs, taking:
            self.pid = await self._template.copy(theirs, taking)
        self._channel = Channel(ours, self)
        await self._channel.open()
        self._channel.greet(self._start)
        self._handing_over = HandingOver(giving)
        self._heard = time.monotonic()
        self._front.started(self)
        watching = asyncio.create_task(self._watch())
        try:
            await self._channel.serve()
        finally:
            self._ready.clear()
            self.sockets = SocketCounts()
            watching.cancel()
            self._channel = None
            self._handing_over.close()
            self._handing_over = None
            await self._gone()

    async def _watch(
        self,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        """Kill a process that is silent for too long, while this one was there to listen."""
        while True:
            before = clock()
            await sleep(WATCH_S)
            if clock() - before > SILENT_S / 2:  # the whole machine stood still, or was out of memory
                self._heard = clock()
            limit = SILENT_S if self._ready.is_set() else START_S
            if clock() - self._heard > limit:
                log.error("the process %d of the rooms %d hangs and is killed", self.pid, self.index)
                self._kill(signal.SIGKILL)

    async def _gone(self) -> None:
        """Wait until the process has ended: two must never write the same journals."""
        deadline = time.monotonic() + STOP_S
        while _runs(self.pid):
            if time.monotonic() > deadline:
                self._kill(signal.SIGKILL)
            await asyncio.sleep(0.02)

    def _kill(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            if self.pid:
                os.kill(self.pid, number)


def _runs(pid: int) -> bool:
    try:
        ended: bool = psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
    return not ended
