"""The listening socket, and Uvicorn configured for the game: small buffers, so that old frames do not pile up."""

import asyncio
import contextlib
import errno
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import uvicorn
from fastapi import FastAPI

from movingout.maps.errors import MovingOutError
from movingout.server.connection.uvicorn_protocols import GameWebSocketProtocol, http_protocol
from movingout.server.host import Host
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings

SEND_BUFFER = 32 * 1024
RECEIVE_BUFFER = 8 * 1024  # so that a flood is held back at its sender
BACKLOG = 512
TLS_HANDSHAKE_S = 5.0


class CannotListen(MovingOutError):
    """The server cannot listen on this address."""


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; accepted connections inherit its buffer sizes. Raises CannotListen with what would work."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        listening.bind((host, port))
        listening.listen(BACKLOG)
    except (OSError, OverflowError) as error:
        listening.close()
        raise CannotListen(_why(host, port, error)) from None
    listening.setblocking(False)
    return listening


def _why(host: str, port: int, error: Exception) -> str:
    code = getattr(error, "errno", None)
    if code == errno.EADDRINUSE:
        return f"port {port} is in use already; stop the other program or choose another one: --port {port + 1}"
    if code == errno.EACCES:
        return f"port {port} needs special rights; choose one from 1024 up, such as --port 8000"
    if code == errno.EADDRNOTAVAIL or isinstance(error, socket.gaierror):
        return f"{host} is no address of this machine; use 127.0.0.1 (this machine only) or 0.0.0.0 (the network too)"
    return f"cannot listen at {host}:{port}: {error}"


class GameServer(uvicorn.Server):
    """Uvicorn that ends the games before it closes the connections, and reports when it is ready."""

    def __init__(self, config: uvicorn.Config, host: Host, on_ready: Callable[[], None]) -> None:
        super().__init__(config)
        self._host = host
        self._on_ready = on_ready

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """As Uvicorn's, but an orderly end is not followed by the signal's own: the exit code is 0."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self.handle_exit) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        loop = asyncio.get_running_loop()
        if self.config.is_ssl:  # Uvicorn has no option for it, and asyncio waits 60 s for clients that say nothing
            loop.create_server = partial(  # type: ignore[method-assign]
                loop.create_server, ssl_handshake_timeout=TLS_HANDSHAKE_S
            )
        await super().startup(sockets)
        if self.started:
            self._on_ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await self._host.suspend()
        await super().shutdown(sockets)


def game_server(
    app: FastAPI, settings: Settings, certificate: Certificate | None, on_ready: Callable[[], None]
) -> GameServer:
    """Uvicorn set up for the game: strict frames, no compression, no access log (addresses hold room names)."""
    config = uvicorn.Config(
        app,
        http=http_protocol(settings.limits),
        ws=GameWebSocketProtocol,
        ws_max_size=settings.limits.frame_bytes,
        ws_per_message_deflate=False,
        ws_ping_interval=20.0,
        ws_ping_timeout=20.0,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=5,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=list(settings.trusted_proxies),
        ssl_certfile=_path(certificate and certificate.certificate),
        ssl_keyfile=_path(certificate and certificate.key),
    )
    return GameServer(config, app.state.host, on_ready)


def _path(path: Path | None) -> str | None:
    return None if path is None else str(path)
