"""The front's view of the agent service: started, watched, replaced when it dies, and connected to every process."""

import asyncio
import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

from movingout.server.processes import agent_service
from movingout.server.processes.agent_service import AgentService, StartAgents
from movingout.server.processes.channel import Channel, ProcessGone
from movingout.server.processes.handover import HandingOver, closed_on_error, socket_pair
from movingout.server.processes.kept_process import KeptProcess

REPORT_S = 2.0  # that whoever reads the metrics waits for an answer
BURIED_S = 10.0  # from the end of the channel to that of the process


class AgentLink(KeptProcess):
    """`on_ready` is called when a service can be connected to. Use inside a running event loop."""

    def __init__(self, start: StartAgents, on_ready: Callable[[], None]) -> None:
        super().__init__("the agent service")
        self._start = start
        self._on_ready = on_ready
        self._channel: Channel[AgentLink, AgentService] | None = None
        self._told: tuple[str, ...] = ()  # what does not work there
        self._handing_over: HandingOver | None = None

    def connection(self) -> socket.socket | None:
        """An end of a new connection to the service; None while there is none."""
        if self._handing_over is None:
            return None
        ours, theirs = socket.socketpair()
        with theirs:
            try:
                self._handing_over.give(theirs.fileno(), b"rooms")
            except ProcessGone:
                ours.close()
                return None
        return ours

    async def call(self, work: Callable[..., Any], *args: Any) -> Any:
        """The result of `work(service, ...)`. Raises ProcessGone."""
        if self._channel is None:
            raise ProcessGone("the agents are being restarted; try again in a moment")
        return await self._channel.call(work, *args)

    async def report(self) -> dict[str, Any] | None:
        """What the service says of itself and its workers; None while there is none that answers."""
        try:
            found: dict[str, Any] = await asyncio.wait_for(self.call(agent_service.report), REPORT_S)
        except (ProcessGone, TimeoutError):
            return None
        return found

    def heard(self, faults: tuple[str, ...]) -> None:
        """Told by the service."""
        self._told = faults
        self.restart_record.seen()

    def faults(self) -> Iterator[str]:
        """Those of the service, and of whoever keeps it running."""
        yield from self._told
        yield from super().faults()

    async def _one_life(self) -> None:
        ours, theirs = socket.socketpair()
        giving, taking = socket_pair()
        with closed_on_error(ours, giving), theirs, taking:
            process = _spawn(theirs, taking)
        self.pid = process.pid
        self._channel = Channel(ours, self)
        await self._channel.open()
        self._channel.greet(self._start)
        self._handing_over = HandingOver(giving)
        self._on_ready()
        try:
            await self._channel.serve()
        finally:
            self._told = ()
            self._channel = None
            self._handing_over.close()
            self._handing_over = None
            await asyncio.shield(asyncio.to_thread(_bury, process))


def _spawn(control: socket.socket, handover: socket.socket) -> "subprocess.Popen[bytes]":
    # Imported rather than run, because the messages name the types of the imported module.
    program = "import sys; from movingout.server.processes.agent_service import main; main(sys.argv[1:])"
    return subprocess.Popen(
        [sys.executable, "-P", "-c", program, str(control.fileno()), str(handover.fileno())],
        stdin=subprocess.DEVNULL,
        pass_fds=(control.fileno(), handover.fileno()),
        start_new_session=True,
    )


def _bury(process: "subprocess.Popen[bytes]") -> None:
    try:
        process.wait(BURIED_S)
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)
        process.wait()
