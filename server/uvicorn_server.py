"""The listening socket, and Uvicorn configured for the game: small buffers, so that old frames do not pile up."""

import asyncio
import contextlib
import errno
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, Protocol, cast

import uvicorn
from starlette.applications import Starlette

from movingout.maps.errors import MovingOutError
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.connection_limits import ConnectionLimits, both_forms
from movingout.server.connection.hosts import find_own_name
from movingout.server.connection.https_redirect import sent_to_https
from movingout.server.connection.tls_acceptor import TlsAcceptor
from movingout.server.connection.uvicorn_protocols.http_protocol import GameHttpProtocol, http_protocol
from movingout.server.connection.uvicorn_protocols.websocket_protocol import GOODBYE_S, GameWebSocketProtocol
from movingout.server.drain_signal import DRAIN, let_in
from movingout.server.open_files import most_connections
from movingout.server.security.certificate import Certificate, keep_valid
from movingout.server.settings import Settings

SEND_BUFFER = 32 * 1024
RECEIVE_BUFFER = 8 * 1024  # so that a flood is held back at its sender
BACKLOG = 128  # connections that are accepted in one turn of the loop
TLS_HANDSHAKE_S = 5.0
HANDSHAKES = 0.25  # of all connections: so many are in their handshakes at once
CERTIFICATE_S = 60.0  # between two looks whether the certificate ends, or was made anew by another process
DRAIN_S = 900.0  # for rounds to end; those that have not are suspended


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


class SuspendedHost(Protocol):
    """What keeps the games of a server (server.host.Host, server.processes.front.Front)."""

    settings: Settings

    async def suspend(self) -> None: ...

    async def drain(self, within_s: float) -> None: ...


class GameServer(uvicorn.Server):
    """Uvicorn that ends the games before it closes the connections, and reports when it is ready.

    SIGTERM ends it at once, and rounds go on after the next start; SIGUSR1 lets those that have begun end before.
    """

    _draining: "asyncio.Task[None] | None" = None
    _acceptor: TlsAcceptor | None = None

    def __init__(
        self, config: uvicorn.Config, app: Starlette, on_ready: Callable[[], None], connections: ConnectionLimits
    ) -> None:
        super().__init__(config)
        self._connections = connections
        self.app = app
        self._host: SuspendedHost = app.state.host
        self._on_ready = on_ready

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """As Uvicorn's, but an orderly end is not followed by the signal's own: the exit code is 0."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self.handle_exit) for number in (signal.SIGINT, signal.SIGTERM)}
        if DRAIN is not None:
            before[DRAIN] = signal.signal(DRAIN, self._drain_soon)
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _drain_soon(self, number: int, frame: FrameType | None) -> None:
        self._loop.call_soon_threadsafe(self.drain)

    def drain(self) -> None:
        """End when the rounds that have begun are over; called in the event loop."""
        if self._draining is None:
            self._draining = asyncio.create_task(self._end_after_rounds())

    async def _end_after_rounds(self) -> None:
        await self._host.drain(DRAIN_S)
        self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        self._loop = asyncio.get_running_loop()
        find_own_name()
        if self.config.is_ssl and sockets:  # Uvicorn would hear of connections only after their handshakes
            most = int(HANDSHAKES * self._connections.most)
            self._acceptor = TlsAcceptor(sockets[0], self.adopt, most, self.elsewhere)
            await super().startup([])
            self._acceptor.start()
        else:
            await super().startup(sockets)
        if self.config.is_ssl:
            work = partial(self.look_at_certificate, renews=bool(sockets))
            self.app.state.host.background.repeat("the certificate", work, CERTIFICATE_S)
        if self.started:
            self._on_ready()
            let_in()

    async def look_at_certificate(self, renews: bool) -> None:
        """New connections get the certificate that is in the folder now; the process that listens makes it anew.

        Raises OSError.
        """
        files = Certificate(Path(str(self.config.ssl_certfile)), Path(str(self.config.ssl_keyfile)))
        if renews:
            quiet = self.app.state.host.room_count == 0 and not self._connections.any_open
            await asyncio.to_thread(keep_valid, files, quiet)
        if files.certificate.exists() and self.config.ssl is not None:
            self.config.ssl.load_cert_chain(files.certificate, files.key, password="")

    def elsewhere(self, connection: socket.socket, address: str) -> bool:
        """Whether a connection from this address was given to another process instead."""
        return False

    @property
    def _parts(self) -> dict[str, Any]:
        """What Uvicorn makes a protocol of."""
        return {"config": self.config, "server_state": self.server_state, "app_state": self.lifespan.state}

    async def adopt(self, connection: socket.socket) -> None:
        """Serve an accepted connection, from its first byte; it counts from now on. Raises OSError."""
        address = connection.getpeername()[0]
        protocol = cast(type[GameHttpProtocol], self.config.http_protocol_class)(**self._parts)
        protocol.counted_for = address
        try:
            if not self._connections.opened(address, tls=self.config.is_ssl):
                raise ConnectionRefusedError("too many connections")
            began = time.monotonic()
            if self.config.is_ssl and await sent_to_https(connection, self._host.settings, TLS_HANDSHAKE_S):
                connection.close()
                return
            left_s = max(TLS_HANDSHAKE_S - (time.monotonic() - began), 0.1)
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: protocol,
                connection,
                ssl=self.config.ssl,
                ssl_handshake_timeout=left_s if self.config.is_ssl else None,
                ssl_shutdown_timeout=GOODBYE_S if self.config.is_ssl else None,
            )
        finally:
            if protocol.transport is None:  # it did not get as far as to count itself out
                self._connections.closed(address)

    async def adopt_request(self, connection: socket.socket, request: bytes) -> None:
        """Serve a connection whose request for a websocket was read elsewhere, and count it. Raises OSError."""
        address = connection.getpeername()[0]
        protocol = GameWebSocketProtocol(**self._parts)
        await asyncio.get_running_loop().connect_accepted_socket(lambda: protocol, connection)
        allowed = self._connections.opened(address)
        protocol.count_until_gone(partial(self._connections.closed, address))
        if allowed:
            protocol.data_received(request)
        else:
            protocol.abort()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if self._acceptor is not None:
            self._acceptor.stop()
        await self._host.suspend()
        await super().shutdown(sockets)


def game_server(
    app: Starlette,
    settings: Settings,
    certificate: Certificate | None,
    on_ready: Callable[[], None],
    kind: type[GameServer] = GameServer,
) -> GameServer:
    """Uvicorn set up for the game: strict frames, no compression, no access log (addresses hold room names)."""
    admission: AdmissionControl = app.state.host.admission
    connections = ConnectionLimits(
        settings.limits,
        settings.trusted_proxies,
        time.monotonic,
        admission.refusals,
        most=most_connections(settings.limits),
        websockets=lambda: admission.sockets,
    )
    config = uvicorn.Config(
        app,
        http=http_protocol(settings.limits, connections),
        backlog=BACKLOG,
        ws=GameWebSocketProtocol,
        ws_max_size=settings.limits.frame_bytes,
        ws_per_message_deflate=False,
        ws_ping_interval=20.0,
        ws_ping_timeout=20.0,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=5,
        log_config=None,  # what it would set up ends our limits, JSON and addresses left out (monitoring.logs)
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=both_forms(settings.trusted_proxies),
        ssl_certfile=_path(certificate and certificate.certificate),
        ssl_keyfile=_path(certificate and certificate.key),
    )
    return kind(config, app, on_ready, connections)


def _path(path: Path | None) -> str | None:
    return None if path is None else str(path)
