"""How a connection ends: with a code and a reason, or dropped without a word."""

import asyncio
import logging

import msgspec

from movingout.server import messages as m
from movingout.server.connection.asgi import Send, send_frame
from movingout.server.notices import NOTHING, Notice

log = logging.getLogger(__name__)

NO_ROOM = Notice("no_room", "This room no longer exists. Start a new game.")
KEPT = Notice(
    "room_kept",
    "This game is kept, but the server cannot open it at the moment. This page reconnects automatically once it can.",
)
FAILED = Notice("connection_failed", "Something went wrong with this connection.")


class CloseConnection(Exception):
    """Ends the connection with a close code and a notice; 0 drops the connection without a word."""

    def __init__(self, code: int, notice: Notice = NOTHING) -> None:
        super().__init__(notice.message)
        self.code = code
        self.notice = notice


def no_room(room_id: str) -> CloseConnection:
    """How a connection ends whose room is not here."""
    return CloseConnection(m.CLOSE_NOT_FOUND, NO_ROOM)


def not_understood(message: str) -> CloseConnection:
    """How a connection ends whose client sends rubbish."""
    return CloseConnection(m.CLOSE_BAD_MESSAGE, Notice("bad_request", message))


def closing_of(task: "asyncio.Task[None]") -> CloseConnection | None:
    """How a task ended, None while it runs. An unexpected error is logged."""
    if not task.done() or task.cancelled():
        return None
    error = task.exception()
    if isinstance(error, CloseConnection):
        return error
    if error is not None and type(error).__name__ != "ClientDisconnected":
        log.error("a connection failed", exc_info=error)
        return CloseConnection(m.CLOSE_RETRY_LATER, FAILED)
    return CloseConnection(0)


async def say_goodbye(send: Send, closing: CloseConnection) -> None:
    """Close an accepted connection with a code and the reason."""
    notice = closing.notice
    bye = m.Bye(code=closing.code, message=notice.message, error=notice.code, values=notice.values)
    await send_frame(send, msgspec.json.encode(bye).decode())
    await send({"type": "websocket.close", "code": closing.code})
