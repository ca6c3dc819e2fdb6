"""Uvicorn's websocket protocol with a direct path for small binary frames, limits, and dropping a connection."""

import asyncio
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

from uvicorn import Config
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Response
from websockets.server import ServerProtocol

from movingout.server.connection.asgi import WIRE, OnBinary
from movingout.server.connection.security_headers import OF_REFUSALS, plain_refusal
from movingout.server.connection.uvicorn_protocols.websocket_frames import (
    begins_small_binary,
    frame_end,
    frame_of,
    is_ascii_handshake,
    is_small_binary,
    is_utf8,
)

try:
    from websockets.speedups import apply_mask
except ImportError:  # a platform without the compiled part
    from websockets.utils import apply_mask

CONTROLS_PER_S = 5.0  # pings and pongs, which no message counts
CONTROL_BURST = 50.0
MOST_FRAGMENTS = 8  # of one message; ours are never cut
AFTER_CLOSE_BYTES = 16 * 1024
GOODBYE_S = 10.0  # for a client to hang up, as long as Uvicorn waits for the answer to its close frame
CONTINUATION, PING, PONG = 0x0, 0x9, 0xA
INVALID_DATA = 1007  # close code (RFC 6455, 7.4.1)
NO_HANDSHAKE = "This is not the handshake of a websocket.\n"


class SecureServerProtocol(ServerProtocol):
    """The state of a connection; a handshake that is refused is answered with the security headers."""

    def send_response(self, response: Response) -> None:
        if response.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            for name, value in OF_REFUSALS:
                response.headers.setdefault(name.decode(), value.decode())
        super().send_response(response)


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

    def __init__(self, config: Config, *args: Any, **kwargs: Any) -> None:
        super().__init__(config, *args, **kwargs)
        self.conn = SecureServerProtocol(max_size=config.ws_max_size, logger=self.logger)  # as Uvicorn's: no extensions

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
                self.transport.write(plain_refusal("400 Bad Request", NO_HANDSHAKE, self.default_headers))
                self.transport.close()
            return
        if not self.handshake_complete:  # clients wait for the answer (RFC 6455, 4.1); Uvicorn would read on, and raise
            self.transport.abort()
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
