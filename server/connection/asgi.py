"""What the websocket endpoint speaks with the server below it: ASGI's messages, and a socket without ASGI's queues."""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any, Protocol

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]
OnBinary = Callable[[bytes], bool]  # False: the connection is closing
WIRE = "movingout.wire"  # where the scope's extensions hold the DirectSocket of a connection


class DirectSocket(Protocol):
    """A connection without ASGI's queues (GameWebSocketProtocol in server.connection.uvicorn_protocols)."""

    def listen(self, on_binary: OnBinary, on_writable: Callable[[], None]) -> None:
        """Pass every small binary message to `on_binary`; call `on_writable` when more can be written."""

    def stop_listening(self) -> None: ...

    def count_until_gone(self, uncount: Callable[[], None]) -> None: ...

    def write(self, message: str | bytes) -> bool: ...

    def abort(self) -> None: ...

    def hand_over(self, give: Callable[[int, bytes], None]) -> bool: ...


async def send_frame(send: Send, frame: str | bytes) -> None:
    """Send a text or a binary message."""
    await send({"type": "websocket.send", "text" if isinstance(frame, str) else "bytes": frame})


async def refuse(send: Send, status: int, sentence: str) -> None:
    """Answer a handshake with an error."""
    body = sentence.encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "websocket.http.response.start", "status": status, "headers": headers})
    await send({"type": "websocket.http.response.body", "body": body})
