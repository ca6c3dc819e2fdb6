"""The listening end of a server with several processes."""

import asyncio
import contextlib
import logging
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from fastapi import FastAPI

from movingout.server.app import assemble
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.expected import Expected
from movingout.server.processes.front import Front
from movingout.server.processes.front_endpoint import FrontEndpoint
from movingout.server.processes.handover import TLS
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings
from movingout.server.uvicorn_server import GameServer, game_server

log = logging.getLogger(__name__)

AT_ONCE = 64  # connections accepted before others are served
FULL_S = 0.5  # of waiting when no more files can be opened


def create_front_app(front: Front) -> FastAPI:
    """The pages and the API of a server with several processes; `app.state.host` is the front."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await front.start()
        yield
        await front.stop()

    return assemble(front, FrontEndpoint(front), lifespan)


def front_server(
    app: FastAPI, settings: Settings, certificate: Certificate | None, on_ready: Callable[[], None]
) -> GameServer:
    """Uvicorn set up for the front."""
    return game_server(app, settings, certificate, on_ready, kind=FrontServer)


class FrontServer(GameServer):
    """With TLS it accepts connections itself: those that are expected in another process go there as they are."""

    _accepting: "_Accepting | None" = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        if not self.config.is_ssl or not sockets:
            await super().startup(sockets)
            return
        self._accepting = _Accepting(self, sockets[0], self.app.state.host.expected)
        await super().startup([])
        self._accepting.start()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if self._accepting is not None:
            self._accepting.stop()
        await super().shutdown(sockets)


class _Accepting:
    def __init__(self, server: GameServer, listening: socket.socket, expected: Expected) -> None:
        self._server = server
        self._listening = listening
        self._expected = expected
        self._tasks: set[asyncio.Task[None]] = set()

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
            link = self._expected.take(address[0])
            if link is not None:
                with contextlib.suppress(ProcessGone), connection:  # its client comes back
                    link.give(connection.fileno(), TLS)
                continue
            task = asyncio.create_task(self._serve(connection))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _serve(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        try:
            await self._server.adopt(connection)
        except OSError as error:  # it has hung up, or never spoke TLS
            log.debug("a connection is gone: %s", error)
            connection.close()
