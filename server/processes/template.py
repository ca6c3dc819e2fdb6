"""A process that has loaded everything and is copied for each process with rooms: a copy is there within milliseconds.

Copies share its memory (modules, maps, distance fields) as long as they do not change it. It has one thread and no
event loop, which is what makes copying safe. Started as `python -m movingout.server.processes.template SOCKET_FD`.
"""

import asyncio
import contextlib
import gc
import os
import signal
import socket
import subprocess
import sys

from movingout.agents.worker.thread_budget import ONE_THREAD
from movingout.server.processes.message_sockets import message_sockets

COPIES_S = 60.0  # that the first copy may take: everything is loaded before


class TemplateProcess:
    """The front's view of it. `keep` is a descriptor that all copies hold open: the lock of the data folder."""

    def __init__(self, keep: int) -> None:
        self._keep = keep
        self._link: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._one_at_a_time = asyncio.Lock()

    def start(self) -> None:
        ours, theirs = message_sockets()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "movingout.server.processes.template", str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(), self._keep),
                env={**os.environ, **ONE_THREAD},
                start_new_session=True,  # Ctrl-C is the front's affair
            )
        ours.setblocking(False)
        self._link = ours

    async def copy(self, control: socket.socket, handover: socket.socket) -> int:
        """The pid of a new process with rooms that holds these two sockets. Raises OSError."""
        async with self._one_at_a_time:
            if self._link is None or self._process is None or self._process.poll() is not None:
                self.close()
                self.start()
            assert self._link is not None and self._process is not None
            try:
                return await self._copied(self._link, control, handover)
            except BaseException:  # a late answer would be taken for that to the next request
                self._process.kill()
                self.close()
                raise

    async def _copied(self, link: socket.socket, control: socket.socket, handover: socket.socket) -> int:
        socket.send_fds(link, [b"copy"], [control.fileno(), handover.fileno()])
        answer = await asyncio.wait_for(asyncio.get_running_loop().sock_recv(link, 64), COPIES_S)
        if not answer:
            raise OSError("the process that starts the others has ended")
        return int(answer)

    def close(self) -> None:
        if self._link is not None:
            self._link.close()
            self._link = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(2.0)
            self._process.kill()
            self._process.wait()
            self._process = None


def main(arguments: list[str]) -> None:
    from movingout.server.processes import room_process
    from movingout.server.room_host import warm_up

    link = socket.socket(fileno=int(arguments[0]))
    warm_up()
    gc.collect()
    gc.freeze()
    for number in (signal.SIGTERM, signal.SIGUSR1):  # it ends with the front, after the copies
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # copies that end leave nothing behind
    while True:
        message, descriptors, _, _ = socket.recv_fds(link, 64, 2)
        if not message:
            return
        pid = os.fork()
        if pid == 0:
            link.close()
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            control, handover = descriptors
            room_process.main(socket.socket(fileno=control), socket.socket(fileno=handover))
            return
        for descriptor in descriptors:
            os.close(descriptor)
        link.send(str(pid).encode())


if __name__ == "__main__":
    main(sys.argv[1:])
