"""The front's view of the agent service: started, watched, replaced when it dies, and connected to every process."""

import asyncio
import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from movingout.server.processes import agent_service
from movingout.server.processes.agent_service import AgentService, StartAgents
from movingout.server.processes.channel import Channel, ProcessGone
from movingout.server.processes.handover import HandingOver, socket_pair
from movingout.server.processes.kept_process import KeptProcess

BURIED_S = 10.0  # from the end of the channel to that of the process


class AgentLink(KeptProcess):
    """`on_ready` is called when a service can be connected to. Use inside a running event loop."""

    def __init__(self, start: StartAgents, on_ready: Callable[[], None]) -> None:
        super().__init__("the agent service")
        self._start = start
        self._on_ready = on_ready
        self._channel: Channel[None, AgentService] | None = None
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

    async def report(self) -> list[dict[str, float]]:
        try:
            rows: list[dict[str, float]] = await self.call(agent_service.report)
        except ProcessGone:
            return []
        return rows

    async def _one_life(self) -> None:
        ours, theirs = socket.socketpair()
        giving, taking = socket_pair()
        with theirs, taking:
            process = _spawn(theirs, taking)
        self.pid = process.pid
        self._channel = Channel(ours, None)
        await self._channel.open()
        self._channel.greet(self._start)
        self._handing_over = HandingOver(giving)
        self._on_ready()
        try:
            await self._channel.serve()
        finally:
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
