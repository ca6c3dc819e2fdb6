"""An agent worker process: started, supervised, and replaced when it dies or hangs.

Runs on the event loop and never waits for the worker.
"""

import asyncio
import contextlib
import logging
import os
import socket
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import IO, Protocol

import msgspec

from movingout.agents.trial import LOADING_LIMIT_S
from movingout.agents.worker.heartbeat import Activity, WorkerHeartbeat
from movingout.agents.worker.messages import FrameBuffer, FromWorker, ToWorker, frame, read_from_worker
from movingout.agents.worker.thread_budget import MOST_CORES, ONE_THREAD
from movingout.server.agent_workers.process_restarts import ProcessRestarts

log = logging.getLogger(__name__)

HANG_S = {
    "idle": 3.0,
    "deciding": 2.0,
    "loading": LOADING_LIMIT_S,
    "overrun": 2.0,
}  # seconds in one phase after which the worker is replaced
PROGRAM = (  # Ctrl-C is the server's affair, also while the worker still imports
    "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); "
    "from movingout.agents.worker.process import main; main(sys.argv[1:])"
)
WATCH_EVERY_S = 0.25
STILL_S = 1.0  # a sleep of WATCH_EVERY_S that takes longer
QUICK_DEATH_S = 1.0  # a worker that died younger than this is not replaced at once


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


class AgentProcess:
    """A worker process that is restarted whenever it is lost.

    `on_message` receives every message of the worker; `on_lost` is called with the last activity of a lost worker, just
    before the next one is started; `on_ready` is called when the next one has connected.
    """

    def __init__(
        self,
        on_message: Callable[[FromWorker], None],
        on_ready: Callable[[], None],
        on_lost: Callable[[Activity], None],
        thread_cores: float = MOST_CORES,
    ) -> None:
        self._on_message = on_message
        self._on_ready = on_ready
        self._on_lost = on_lost
        self._thread_cores = thread_cores
        self._link: asyncio.StreamWriter | None = None
        self._task: asyncio.Task[None] | None = None
        self._restart_record = ProcessRestarts("an agent worker")
        self.pid = 0
        self.overruns = 0  # lives that ended because of an agent's threads

    def start(self) -> None:
        """Start the worker and keep it running until `close`."""
        self._restart_record.seen()
        self._task = asyncio.get_running_loop().create_task(self._keep_alive())

    async def close(self) -> None:
        """Stop the worker for good."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task

    @property
    def connected(self) -> bool:
        """Whether a worker is connected."""
        return self._link is not None

    def send(self, message: ToWorker) -> None:
        """Send a message; it is dropped while no worker is connected (`on_ready` says when one is)."""
        if self._link is not None and not self._link.is_closing():
            self._link.write(frame(message))

    @property
    def restarts(self) -> int:
        """How often it was replaced."""
        return self._restart_record.restarts

    def faults(self) -> Iterator[str]:
        """Whether it does not serve, and will not by itself."""
        if self.connected:
            self._restart_record.seen()
        yield from self._restart_record.faults()

    async def _keep_alive(self) -> None:
        while True:
            born = time.monotonic()
            activity = await self._one_life_or_none()
            self.overruns += activity.phase == "overrun"
            self._restart_record.ended(by_itself=activity.phase == "idle")
            self._on_lost(activity)
            if time.monotonic() - born < QUICK_DEATH_S:
                await asyncio.sleep(QUICK_DEATH_S)

    async def _one_life_or_none(self) -> Activity:
        """Whatever goes wrong, there is to be a next life: without files or memory for a moment, none can begin."""
        try:
            activity = await self._one_life()
            what = (
                "lost because an agent computes on" if activity.phase == "overrun" else f"lost while {activity.phase}"
            )
            log.warning("agent worker %d %s; starting another", self.pid, what)
        except Exception as error:  # whatever it is, another worker is tried
            log.error("an agent worker cannot be run: %s", error, exc_info=not isinstance(error, OSError))
            return Activity(0.0, "idle", None)
        return activity

    async def _one_life(self) -> Activity:
        """Run one worker until it is lost; return its last activity. Raises OSError."""
        ours, theirs = socket.socketpair()
        try:
            with theirs, tempfile.TemporaryFile() as file:
                heartbeat = WorkerHeartbeat(file.fileno())
                heartbeat.write("idle")
                process = await _spawn(theirs, file, self._thread_cores)
        except BaseException:
            ours.close()
            raise
        self.pid = process.pid
        try:
            reader, self._link = await asyncio.open_connection(sock=ours)
            self._on_ready()
            await self._until_lost(reader, heartbeat)
            return heartbeat.read()
        finally:
            await self._bury(process)
            heartbeat.close()

    async def _until_lost(self, reader: asyncio.StreamReader, heartbeat: WorkerHeartbeat) -> None:
        tasks = [asyncio.create_task(self._listen(reader)), asyncio.create_task(_watch(heartbeat))]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _listen(self, reader: asyncio.StreamReader) -> None:
        buffer = FrameBuffer()
        try:
            while data := await reader.read(1 << 16):
                for body in buffer.feed(data):
                    self._on_message(read_from_worker(body))
        except (ConnectionError, msgspec.MsgspecError) as error:
            log.warning("agent worker %d: %s", self.pid, error)

    async def _bury(self, process: asyncio.subprocess.Process) -> None:
        if self._link is not None:
            self._restart_record.seen()
            self._link.close()
            with contextlib.suppress(OSError):
                await self._link.wait_closed()
            self._link = None
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _spawn(link: socket.socket, file: IO[bytes], thread_cores: float) -> asyncio.subprocess.Process:
    arguments = ["-P", "-c", PROGRAM, str(link.fileno()), str(file.fileno()), str(thread_cores)]
    return await asyncio.create_subprocess_exec(
        sys.executable,
        *arguments,
        stdin=asyncio.subprocess.DEVNULL,
        pass_fds=(link.fileno(), file.fileno()),
        env={**os.environ, **ONE_THREAD},
    )


async def _watch(
    heartbeat: WorkerHeartbeat,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
) -> None:
    """Return when the worker has been in one phase for too long."""
    starting, awake = heartbeat.read().since, clock()
    while True:
        before = clock()
        await sleep(WATCH_EVERY_S)
        if clock() - before > STILL_S:  # the whole machine stood still
            awake = clock()
        since, phase, _ = heartbeat.read()
        limit = HANG_S["loading"] if since == starting else HANG_S[phase]
        if clock() - max(since, awake) > limit:
            return
