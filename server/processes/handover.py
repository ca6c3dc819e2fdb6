"""Connections that change the process before their handshake: the front accepts them, their room's home serves them.

The socket itself is handed over (SCM_RIGHTS), with the request that came on it, so no process stands between a player
and the room afterwards.
"""

import asyncio
import contextlib
import logging
import os
import socket
from collections import deque
from collections.abc import Callable, Iterator

from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.message_sockets import message_sockets
from movingout.server.uvicorn_server import GameServer

log = logging.getLogger(__name__)

MOST_BYTES = 64 * 1024  # of a request; the HTTP server refuses longer ones
MOST_WAITING = 100  # connections for a process that takes none: each is a file, and nothing counts them
PLAIN, TLS, AGENTS = b"p", b"t", b"a"  # what kind of connection is handed over


def socket_pair() -> tuple[socket.socket, socket.socket]:
    """Two ends that keep the boundaries of messages."""
    ours, theirs = message_sockets()
    ours.setblocking(False)
    theirs.setblocking(False)
    return ours, theirs


@contextlib.contextmanager
def closed_on_error(*links: socket.socket) -> Iterator[None]:
    """Close these when the block fails: nobody is at the other end."""
    try:
        yield
    except BaseException:
        for link in links:
            link.close()
        raise


class HandingOver:
    """The front's end."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._waiting: deque[tuple[int, bytes]] = deque()  # while the other end is slow

    def give(self, descriptor: int, message: bytes) -> None:
        """Pass on a copy of the descriptor. Raises ProcessGone when the other end has ended."""
        if not self._waiting:
            try:
                socket.send_fds(self._link, [message], [descriptor])
                return
            except BlockingIOError:
                asyncio.get_running_loop().add_writer(self._link, self._send)
            except OSError:
                raise ProcessGone("the process of this room has ended") from None
        if len(self._waiting) >= MOST_WAITING and message[:1] != AGENTS:  # that one link is not asked for again
            raise ProcessGone("the process of this room is busy; try again in a moment")
        self._waiting.append((os.dup(descriptor), message))

    def close(self) -> None:
        asyncio.get_running_loop().remove_writer(self._link)
        while self._waiting:
            os.close(self._waiting.popleft()[0])
        self._link.close()

    def _send(self) -> None:
        while self._waiting:
            descriptor, message = self._waiting[0]
            try:
                socket.send_fds(self._link, [message], [descriptor])
            except BlockingIOError:
                return
            except OSError as error:  # its client comes back
                log.warning("a connection was not handed over: %s", error)
            self._waiting.popleft()
            os.close(descriptor)
        asyncio.get_running_loop().remove_writer(self._link)


class TakingOver:
    """The end of a process with rooms: connections go on as if they had been accepted here."""

    def __init__(self, link: socket.socket, server: GameServer, join_agents: Callable[[socket.socket], None]) -> None:
        self._link = link
        self._join_agents = join_agents
        self._server = server
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self) -> None:
        asyncio.get_running_loop().add_reader(self._link, self._receive)

    def stop(self) -> None:
        asyncio.get_running_loop().remove_reader(self._link)

    def _receive(self) -> None:
        try:
            message, descriptors, _, _ = socket.recv_fds(self._link, MOST_BYTES, 1)
        except BlockingIOError:
            return
        if not message:
            self.stop()  # the front has ended
            return
        for descriptor in descriptors:
            if message[:1] == AGENTS:
                self._join_agents(socket.socket(fileno=descriptor))
                continue
            task = asyncio.create_task(self._connect(socket.socket(fileno=descriptor), message))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _connect(self, connection: socket.socket, message: bytes) -> None:
        connection.setblocking(False)
        try:
            if message[:1] == TLS:
                await self._server.adopt(connection)
            else:
                await self._server.adopt_request(connection, message[1:])
        except OSError as error:  # it has hung up meanwhile, or never spoke TLS
            log.debug("a connection that was handed over is gone: %s", error)
            connection.close()
