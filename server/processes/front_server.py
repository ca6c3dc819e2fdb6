"""The listening end of a server with several processes."""

import contextlib
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from fastapi import FastAPI

from movingout.server.app import assemble
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.front import Front
from movingout.server.processes.front_endpoint import FrontEndpoint
from movingout.server.processes.handover import TLS
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings
from movingout.server.uvicorn_server import GameServer, game_server


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
    """With TLS, connections that are expected in another process go there as they are."""

    def elsewhere(self, connection: socket.socket, address: str) -> bool:
        link = self.app.state.host.expected.take(address)
        if link is None:
            return False
        with contextlib.suppress(ProcessGone):  # its client comes back
            link.give(connection.fileno(), TLS)
        return True
