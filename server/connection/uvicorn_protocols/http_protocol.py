"""Uvicorn's HTTP protocol with deadlines, and limits on the size of requests and on how many wait."""

import asyncio
from functools import partial
from typing import Any, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle

from movingout.server.connection.connection_limits import ConnectionLimits
from movingout.server.connection.security_headers import plain_refusal
from movingout.server.connection.uvicorn_protocols.reader_deadline import ReaderDeadline
from movingout.server.connection.uvicorn_protocols.request_size import URL_BYTES, RequestSize
from movingout.server.connection.uvicorn_protocols.websocket_protocol import GameWebSocketProtocol
from movingout.server.settings import Limits

TLS_WAITING_BYTES = 16 * 1024  # encrypted, before more is held back; by default half a megabyte
MOST_PIPELINED = 8  # requests behind one that is not answered yet; browsers and proxies send none
TOO_LARGE = "The address or the headers of this request are too long.\n"


class HeadTooLarge(Exception):
    """Raised in the parser's callbacks; ends as `send_400_response`."""


class TooManyPipelined(Exception):
    """Raised in the parser's callbacks; ends the connection."""


class GameHttpProtocol(HttpToolsProtocol):
    """Drops a connection that trickles its request (slowloris) or sends a head without end.

    Uvicorn alone would wait for ever, and keep every byte. `http_protocol` gives it the limits of a server.
    """

    counted_for: str | None = None  # its address, where it was counted before its TLS handshake
    _limits: Limits
    _counts: ConnectionLimits
    _reader: ReaderDeadline
    _size: RequestSize
    _deadline: asyncio.TimerHandle | None = None
    _address = ""
    _answered: RequestResponseCycle | None = None  # the last one that was begun
    url = b""  # before the first request too

    # ---- the connection -------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if transport.get_extra_info("ssl_object") is not None:
            transport.set_write_buffer_limits(TLS_WAITING_BYTES)
        self._reader = ReaderDeadline(self.loop, transport, self._limits.unread_s)
        self._size = RequestSize(self._limits.body_bytes, head_is_whole=True)
        counted = self.counted_for is not None
        self._address = self.counted_for or (self.client[0] if self.client else "")
        if counted or self._counts.opened(self._address):
            self._set_deadline()
        else:
            transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        self._clear_deadline()
        self._reader.end()
        self._counts.closed(self._address)
        if self._answered is not None:  # Uvicorn tells only the last one that was received
            self._answered.disconnected = True
            self._answered.message_event.set()
        self.pipeline.clear()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self) -> None:
        self._clear_deadline()
        if self.cycle is not None and not self.cycle.response_complete:
            self.transport.abort()  # whoever answers it would never hear that the connection is gone
            return
        super().handle_websocket_upgrade()
        websocket = cast(GameWebSocketProtocol, self.transport.get_protocol())
        websocket.count_until_gone(partial(self._counts.closed, self._address))

    def _set_deadline(self) -> None:
        if self._deadline is None:
            self._deadline = self.loop.call_later(self._limits.header_s, self.transport.abort)

    def _clear_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    # ---- answers --------------------------------------------------------------------------------------------

    def pause_writing(self) -> None:
        """More waits to be sent than should; whoever takes too little of it is gone, or wants us to keep it."""
        super().pause_writing()
        self._reader.look_anew()

    def resume_writing(self) -> None:
        """Most of it has been taken."""
        super().resume_writing()
        self._reader.look_anew()

    def on_response_complete(self) -> None:
        """The end of an answer may wait to be sent, too little of it for `pause_writing`, also after a close."""
        super().on_response_complete()
        self._reader.look()

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: Any) -> None:
        self._answered = cycle
        super()._start_asgi_task(cycle, app)

    # ---- requests -------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.transport.is_closing():
            self._reader.look()
            return
        self._size.add_data(len(data))
        if self._size.head_too_large:
            self._refuse_head()
        elif self._size.too_much_later:
            self.transport.abort()
        elif self._size.head_is_whole and self._is_idle():
            self._set_deadline()  # for any byte, even of no request, Uvicorn forgets that this one is idle

    def _is_idle(self) -> bool:
        """Whether the last request has its answer, and the connection has not become a websocket."""
        return self.cycle is not None and self.cycle.response_complete and self.transport.get_protocol() is self

    def on_message_begin(self) -> None:
        self._set_deadline()
        self._size = RequestSize(self._limits.body_bytes)
        super().on_message_begin()

    def on_url(self, url: bytes) -> None:
        super().on_url(url)
        if len(self.url) > URL_BYTES:
            raise HeadTooLarge

    def on_header(self, name: bytes, value: bytes) -> None:
        """A whole header, of the head or (after a chunked body) of the trailer, which proxies pass on unseen.

        Uvicorn would take a trailer for a header: its X-Forwarded-For would be the proxy's word.
        """
        self._size.add_header(name, value)
        if self._size.headers_too_large:
            raise HeadTooLarge
        if not self._size.head_is_whole:
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        self._size.head_is_whole = True
        if len(self.pipeline) >= MOST_PIPELINED:
            raise TooManyPipelined
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        self._clear_deadline()
        super().on_message_complete()

    def send_400_response(self, msg: str) -> None:
        """Uvicorn's answer to what cannot be parsed, which includes what a callback above refused."""
        if len(self.url) > URL_BYTES or self._size.headers_too_large:
            self._refuse_head()
        elif len(self.pipeline) >= MOST_PIPELINED:
            self.transport.abort()
        else:
            self._refuse("400 Bad Request", msg)

    def _refuse_head(self) -> None:
        self._refuse("431 Request Header Fields Too Large", TOO_LARGE)

    def _refuse(self, status: str, text: str) -> None:
        self.transport.write(plain_refusal(status, text, self.server_state.default_headers))
        self.transport.close()


def http_protocol(limits: Limits, connections: ConnectionLimits) -> type[GameHttpProtocol]:
    """The HTTP protocol of one server, as the class that Uvicorn makes one of for each connection."""

    class ServerHttpProtocol(GameHttpProtocol):
        _limits = limits
        _counts = connections

    return ServerHttpProtocol
