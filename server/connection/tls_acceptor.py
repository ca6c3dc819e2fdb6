"""Accepts the connections of a server with TLS, so that they count before their handshakes, too."""

import asyncio
import contextlib
import logging
import socket
from collections.abc import Awaitable, Callable

log = logging.getLogger(__name__)

AT_ONCE = 64  # connections accepted before others are served
FULL_S = 0.5  # of waiting when no more files can be opened


class TlsAcceptor:
    """Accepts until `stop`; `adopt` serves a connection, and returns after its handshake or raises OSError.

    `elsewhere` may give a connection to another process before its first byte, and says whether it did. At most `most`
    connections are in their handshakes; then the oldest goes, for silent ones take more time than honest ones.
    """

    def __init__(
        self,
        listening: socket.socket,
        adopt: Callable[[socket.socket], Awaitable[None]],
        most: int,
        elsewhere: Callable[[socket.socket, str], bool] = lambda connection, address: False,
    ) -> None:
        self._listening = listening
        self._adopt = adopt
        self._most = most
        self._elsewhere = elsewhere
        self._handshakes: dict[asyncio.Task[None], socket.socket] = {}  # the oldest first

    def start(self) -> None:
        asyncio.get_running_loop().add_reader(self._listening, self._accept)

    def stop(self) -> None:
        asyncio.get_running_loop().remove_reader(self._listening)

    def _accept(self) -> None:
        for _ in range(AT_ONCE):
            try:
                connection, address = self._listening.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                log.error("no connection can be accepted for a moment: %s", error)
                self.stop()
                asyncio.get_running_loop().call_later(FULL_S, self.start)
                return
            if self._elsewhere(connection, address[0]):
                connection.close()
                continue
            task = asyncio.create_task(self._serve(connection))
            self._handshakes[task] = connection
            task.add_done_callback(self._handshakes.pop)
            if len(self._handshakes) > self._most:
                self._drop_oldest()
                return  # until it is closed, the others wait at the door

    def _drop_oldest(self) -> None:
        """Its task sees that the other end is gone, and closes."""
        task, connection = next(iter(self._handshakes.items()))
        del self._handshakes[task]
        self._handshakes[task] = connection  # the newest, so that another one is dropped next
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)

    async def _serve(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        try:
            await self._adopt(connection)
        except OSError as error:  # it has hung up, never spoke TLS, or is one too many
            log.debug("a connection is gone: %s", error)
            connection.close()
