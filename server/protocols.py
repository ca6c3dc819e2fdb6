"""Uvicorn's HTTP and websocket protocols with the two things they lack: deadlines and a way to hang up at once."""

import asyncio
from collections import defaultdict
from typing import Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from server.settings import Limits
from server.socket import ABORT

PINGS_PER_S = 5.0


def http_protocol(limits: Limits) -> type[HttpToolsProtocol]:
    """The HTTP protocol of one server: a whole request within the deadline, so many connections per address."""
    connections: defaultdict[str, int] = defaultdict(int)

    class DeadlineHttpProtocol(HttpToolsProtocol):
        """Drops a connection that trickles its request (slowloris): Uvicorn alone would wait for ever."""

        _deadline: asyncio.TimerHandle | None = None
        _address = ""

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            self._address = self.client[0] if self.client else ""
            connections[self._address] += 1
            if connections[self._address] > limits.connections_per_address:
                transport.abort()
            else:
                self._set_deadline()

        def connection_lost(self, exc: Exception | None) -> None:
            self._clear_deadline()
            self._count_down()
            super().connection_lost(exc)

        def on_message_begin(self) -> None:
            self._set_deadline()
            super().on_message_begin()

        def on_message_complete(self) -> None:
            self._clear_deadline()
            super().on_message_complete()

        def handle_websocket_upgrade(self) -> None:
            self._clear_deadline()
            self._count_down()
            super().handle_websocket_upgrade()

        def _set_deadline(self) -> None:
            if self._deadline is None:
                self._deadline = self.loop.call_later(limits.header_s, self.transport.abort)

        def _clear_deadline(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

        def _count_down(self) -> None:
            connections[self._address] -= 1
            if connections[self._address] <= 0:
                del connections[self._address]

    return DeadlineHttpProtocol


class GameWebSocketProtocol(WebSocketsSansIOProtocol):
    """Lets the endpoint drop a connection without a close frame, and does not answer floods of pings."""

    _pings = 0.0
    _pings_at = 0.0

    def handle_connect(self, event: Any) -> None:
        super().handle_connect(event)
        scope = getattr(self, "scope", None)  # missing when the handshake was refused
        if scope is not None:
            scope["extensions"][ABORT] = self.transport.abort

    def handle_ping(self) -> None:
        now = self.loop.time()
        self._pings = max(0.0, self._pings - (now - self._pings_at) * PINGS_PER_S) + 1.0
        self._pings_at = now
        if self._pings > 10 * PINGS_PER_S:
            self.transport.abort()
            return
        super().handle_ping()
