"""Uvicorn's HTTP and websocket protocols with deadlines, limits on sizes and counts, and dropping a connection."""

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from movingout.server.connection.asgi import WIRE, OnBinary
from movingout.server.connection.connection_limits import ConnectionLimits
from movingout.server.connection.taken_bytes import counts_taken_bytes, taken_bytes
from movingout.server.connection.websocket_frames import (
    begins_small_binary,
    frame_end,
    frame_of,
    is_ascii_handshake,
    is_small_binary,
    is_utf8,
)
from movingout.server.settings import Limits

try:
    from websockets.speedups import apply_mask
except ImportError:  # a platform without the compiled part
    from websockets.utils import apply_mask

CONTROLS_PER_S = 5.0  # pings and pongs, which no message counts
CONTROL_BURST = 50.0
MOST_FRAGMENTS = 8  # of one message; ours are never cut
AFTER_CLOSE_BYTES = 16 * 1024
LEAST_READ_PER_S = 1000  # bytes of an answer, on average
TLS_WAITING_BYTES = 16 * 1024  # encrypted, before more is held back; by default half a megabyte
GOODBYE_S = 10.0  # for a client to hang up, as long as Uvicorn waits for the answer to its close frame
CONTINUATION, PING, PONG = 0x0, 0x9, 0xA
INVALID_DATA = 1007  # close code (RFC 6455, 7.4.1)
URL_BYTES = 4 * 1024
HEAD_BYTES = 16 * 1024  # of a request, without its body
NODE_BYTES = 256 * 1024  # of the longest body that is announced: what nodes of a cluster tell each other
MOST_PIPELINED = 8  # requests behind one that is not answered yet; browsers and proxies send none
TOO_LARGE = (
    b"HTTP/1.1 431 Request Header Fields Too Large\r\ncontent-type: text/plain; charset=utf-8\r\n"
    b"connection: close\r\n\r\nThe address or the headers of this request are too long.\n"
)
NO_HANDSHAKE = (
    b"HTTP/1.1 400 Bad Request\r\ncontent-type: text/plain; charset=utf-8\r\nconnection: close\r\n\r\n"
    b"This is not the handshake of a websocket.\n"
)


class HeadTooLarge(Exception):
    """Raised in the parser's callbacks; ends as `send_400_response`."""


class TooManyPipelined(Exception):
    """Raised in the parser's callbacks; ends the connection."""


class CountedHttpProtocol(HttpToolsProtocol):
    """Uvicorn's, which may be counted from before its TLS handshake: `counted_for` is its address then."""

    counted_for: str | None = None


def http_protocol(limits: Limits, connections: ConnectionLimits) -> type[CountedHttpProtocol]:
    """The HTTP protocol of one server: whole requests, and whole answers taken, within deadlines."""

    class DeadlineHttpProtocol(CountedHttpProtocol):
        """Drops a connection that trickles its request (slowloris) or sends a head without end.

        Uvicorn alone would wait for ever, and keep every byte.
        """

        _deadline: asyncio.TimerHandle | None = None
        _write_deadline: asyncio.TimerHandle | None = None
        _taken = 0  # when the reader was last looked at
        _address = ""
        _head_bytes = 0  # received since the request began, while its head is not whole
        _head_is_whole = True
        _named_bytes = 0  # of the headers received so far
        _later_bytes = 0  # received since the head was whole
        _announced = 0  # bytes of the body
        _answered: RequestResponseCycle | None = None  # the last one that was begun
        url = b""  # before the first request too

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            if transport.get_extra_info("ssl_object") is not None:
                transport.set_write_buffer_limits(TLS_WAITING_BYTES)
            counted = self.counted_for is not None
            self._address = self.counted_for or (self.client[0] if self.client else "")
            if counted or connections.opened(self._address):
                self._set_deadline()
            else:
                transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            self._clear_deadline()
            if self._write_deadline is not None:
                self._write_deadline.cancel()
            connections.closed(self._address)
            if self._answered is not None:  # Uvicorn tells only the last one that was received
                self._answered.disconnected = True
                self._answered.message_event.set()
            self.pipeline.clear()
            super().connection_lost(exc)

        def pause_writing(self) -> None:
            """More waits to be sent than should; whoever takes too little of it is gone, or wants us to keep it."""
            super().pause_writing()
            self._look_anew_unless_counted()
            self._see_that_it_is_taken()

        def resume_writing(self) -> None:
            """Most of it has been taken."""
            super().resume_writing()
            self._look_anew_unless_counted()
            self._see_that_it_is_taken()

        def _look_anew_unless_counted(self) -> None:
            """Where the system does not count what is taken, what is written next would hide it."""
            if self._write_deadline is not None and not counts_taken_bytes(self.transport):
                self._write_deadline.cancel()
                self._write_deadline = None

        def on_response_complete(self) -> None:
            """The end of an answer may wait to be sent, too little of it for `pause_writing`, also after a close."""
            super().on_response_complete()
            self._see_that_it_is_taken()

        def _see_that_it_is_taken(self) -> None:
            if self._write_deadline is None and self.transport.get_write_buffer_size():
                self._wait_for_reader()

        def _wait_for_reader(self) -> None:
            self._taken = taken_bytes(self.transport)
            self._write_deadline = self.loop.call_later(limits.unread_s, self._drop_unless_read)

        def _drop_unless_read(self) -> None:
            self._write_deadline = None
            if not self.transport.get_write_buffer_size():
                return
            if taken_bytes(self.transport) - self._taken < LEAST_READ_PER_S * limits.unread_s:
                self.transport.abort()
            else:
                self._wait_for_reader()

        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            if self.transport.is_closing():
                self._see_that_it_is_taken()
                return
            if not self._head_is_whole:
                self._head_bytes += len(data)
                if self._head_bytes > HEAD_BYTES:
                    self._refuse_head()
                return
            self._later_bytes += len(data)
            if self._later_bytes > self._most_later:
                self.transport.abort()
            elif self.cycle is not None and self.cycle.response_complete and self.transport.get_protocol() is self:
                self._set_deadline()  # for any byte, even of no request, Uvicorn forgets that this one is idle

        @property
        def _most_later(self) -> int:
            """Of a body in small chunks, the trailer, and what is no request: also of a body that no route reads."""
            return 2 * limits.body_bytes + HEAD_BYTES + min(self._announced, NODE_BYTES)

        def on_message_begin(self) -> None:
            self._set_deadline()
            self._head_is_whole, self._head_bytes, self._named_bytes = False, 0, 0
            self._later_bytes = self._announced = 0
            super().on_message_begin()

        def on_url(self, url: bytes) -> None:
            super().on_url(url)
            if len(self.url) > URL_BYTES:
                raise HeadTooLarge

        def on_header(self, name: bytes, value: bytes) -> None:
            """A whole header, of the head or (after a chunked body) of the trailer, which proxies pass on unseen.

            Uvicorn would take a trailer for a header: its X-Forwarded-For would be the proxy's word.
            """
            self._named_bytes += len(name) + len(value)
            if self._named_bytes > HEAD_BYTES:
                raise HeadTooLarge
            if self._head_is_whole:
                return
            if name.lower() == b"content-length" and value.isdigit():
                self._announced = int(value)
            super().on_header(name, value)

        def on_headers_complete(self) -> None:
            self._head_is_whole = True
            if len(self.pipeline) >= MOST_PIPELINED:
                raise TooManyPipelined
            super().on_headers_complete()

        def _start_asgi_task(self, cycle: RequestResponseCycle, app: Any) -> None:
            self._answered = cycle
            super()._start_asgi_task(cycle, app)

        def send_400_response(self, msg: str) -> None:
            """Uvicorn's answer to what cannot be parsed, which includes what a callback above refused."""
            if len(self.url) > URL_BYTES or self._named_bytes > HEAD_BYTES:
                self._refuse_head()
            elif len(self.pipeline) >= MOST_PIPELINED:
                self.transport.abort()
            else:
                super().send_400_response(msg)

        def _refuse_head(self) -> None:
            self.transport.write(TOO_LARGE)
            self.transport.close()

        def on_message_complete(self) -> None:
            self._clear_deadline()
            super().on_message_complete()

        def handle_websocket_upgrade(self) -> None:
            self._clear_deadline()
            if self.cycle is not None and not self.cycle.response_complete:
                self.transport.abort()  # whoever answers it would never hear that the connection is gone
                return
            super().handle_websocket_upgrade()
            websocket = cast(GameWebSocketProtocol, self.transport.get_protocol())
            websocket.count_until_gone(partial(connections.closed, self._address))

        def _set_deadline(self) -> None:
            if self._deadline is None:
                self._deadline = self.loop.call_later(limits.header_s, self.transport.abort)

        def _clear_deadline(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

    return DeadlineHttpProtocol


class GameWebSocketProtocol(WebSocketsSansIOProtocol):
    """Uvicorn's websocket with a direct path for small binary frames, and a limit on pings.

    After the handshake the stream is cut into whole frames here. A small binary frame goes straight to the listener,
    and `write` goes straight to the transport: no queue, no task switch, no pausing of the socket per message
    (together about half the cost of a message). Everything else is left to Uvicorn, which always gets whole frames.
    """

    _uncount: Callable[[], None] | None = None
    _drop: asyncio.TimerHandle | None = None
    _on_binary: OnBinary | None = None
    _on_writable: Callable[[], None] | None = None
    _head = b""  # the request that begins the connection
    _rest = b""
    _after_close = 0
    _controls = 0.0
    _controls_at = 0.0
    _fragments = 0

    def count_until_gone(self, uncount: Callable[[], None]) -> None:
        """Have `uncount` called when the connection is gone; where it was counted so far, it is not from now on."""
        self._end_count()
        self._uncount = uncount
        if self.disconnected:
            self._end_count()

    def _end_count(self) -> None:
        uncount, self._uncount = self._uncount, None
        if uncount is not None:
            uncount()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        if self._drop is not None:
            self._drop.cancel()
        self._end_count()

    def on_task_complete(self, task: "asyncio.Task[None]") -> None:
        """All is said; Uvicorn would wait for ever for a client that takes nothing."""
        super().on_task_complete(task)
        if not self.disconnected:
            self._drop = self.loop.call_later(GOODBYE_S, self.transport.abort)

    def handle_connect(self, event: Any) -> None:
        """What is not ASCII is answered as no handshake: a refusal that quotes it could not be encoded."""
        if not is_ascii_handshake(event.headers.raw_items()):
            return
        super().handle_connect(event)
        scope = getattr(self, "scope", None)  # missing when the handshake was refused
        if scope is not None:
            scope["extensions"][WIRE] = self

    def send_receive_event_to_app(self) -> None:
        """A text that is none is the client's fault: Uvicorn would log a traceback. After a close none is read."""
        if not self.close_sent and self.curr_msg_data_type == "text" and not is_utf8(b"".join(self.frames)):
            self.frames = []
            self.conn.send_close(INVALID_DATA)
            self.handle_parser_exception()
            return
        super().send_receive_event_to_app()

    async def send(self, message: Any) -> None:
        await super().send(message)
        if message["type"] == "websocket.http.response.body":
            self.handshake_complete = True  # refused, which is an answer: Uvicorn would log it as an error

    def listen(self, on_binary: OnBinary, on_writable: Callable[[], None]) -> None:
        """Hand small binary frames to `on_binary`; it returns False once the connection is closing."""
        self._on_binary, self._on_writable = on_binary, on_writable

    def stop_listening(self) -> None:
        self._on_binary = self._on_writable = None

    def data_received(self, data: bytes) -> None:
        if not self.handshake_initiated:
            self._head += data
            super().data_received(data)
            if not self.handshake_initiated:  # the head came as a whole, and the parser will never take it
                self.transport.write(NO_HANDSHAKE)
                self.transport.close()
            return
        if self.close_sent and self._floods_on(len(data)):
            self.transport.abort()
            return
        if self._on_binary is not None and not self._rest and is_small_binary(data):
            self._on_binary(apply_mask(data[6:], data[2:6]))
            return
        buffer = self._rest + data if self._rest else data
        at = 0
        while (end := frame_end(buffer, at, self.config.ws_max_size)) and not self.transport.is_closing():
            if self._on_binary is not None and begins_small_binary(buffer, at):
                heard = self._on_binary(apply_mask(buffer[at + 6 : end], buffer[at + 2 : at + 6]))
                if not heard and len(buffer) - end > AFTER_CLOSE_BYTES:
                    self.transport.abort()
            elif self._is_flood(buffer[at]):
                self.transport.abort()
            else:
                super().data_received(buffer[at:end])
            at = end
        self._rest = buffer[at:]

    def _floods_on(self, size: int) -> bool:
        """Whether a client goes on sending long after our close: Uvicorn would read it for ten seconds."""
        self._after_close += size
        return self._after_close > AFTER_CLOSE_BYTES

    def write(self, message: str | bytes) -> bool:
        """Send a message now; False, and nothing is sent, when the connection would only buffer it."""
        if not self.writable.is_set() or self.close_sent or self.transport.is_closing():
            return False
        frame = frame_of(message)
        if frame is not None:
            self.transport.write(frame)
        return frame is not None

    def hand_over(self, give: Callable[[int, bytes], None]) -> bool:
        """Give the connection away before its handshake: `give` gets its descriptor and the request on it.

        False over TLS, whose state cannot leave this process.
        """
        if self.transport.get_extra_info("ssl_object") is not None:
            return False
        give(self.transport.get_extra_info("socket").fileno(), self._head)
        self.handshake_complete = True  # nothing is left for Uvicorn to answer
        self.transport.abort()
        return True

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._on_writable is not None:
            self._on_writable()

    def abort(self) -> None:
        """Drop the connection at once, with whatever is still queued."""
        self.transport.abort()

    def shutdown(self) -> None:
        """Uvicorn calls it for all connections in turn: an error of one would keep the server from its own end."""
        if self.transport.is_closing():  # perhaps by the client, to whom no second goodbye may be sent
            return
        try:
            super().shutdown()
        except Exception:
            self.logger.exception("a websocket could not be closed in order")
            self.transport.abort()

    def _is_flood(self, head: int) -> bool:
        """Whether frames that are no message of their own, of which this is one by its first byte, are too many."""
        opcode = head & 0x0F
        if opcode in (PING, PONG):
            now = self.loop.time()
            self._controls = max(0.0, self._controls - (now - self._controls_at) * CONTROLS_PER_S) + 1.0
            self._controls_at = now
            return self._controls > CONTROL_BURST
        self._fragments = self._fragments + 1 if opcode == CONTINUATION else 0
        return self._fragments > MOST_FRAGMENTS
