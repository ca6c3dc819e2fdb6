"""Until when the reader of an answer must have taken some of it: whoever takes hardly anything is dropped."""

import asyncio

from movingout.server.connection.uvicorn_protocols.taken_bytes import counts_taken_bytes, taken_bytes

LEAST_READ_PER_S = 1000  # bytes of an answer, on average


class ReaderDeadline:
    """Aborts `transport` when less than LEAST_READ_PER_S of what waits there is taken in `unread_s` seconds."""

    def __init__(self, loop: asyncio.AbstractEventLoop, transport: asyncio.Transport, unread_s: float) -> None:
        self._loop = loop
        self._transport = transport
        self._unread_s = unread_s
        self._timer: asyncio.TimerHandle | None = None
        self._taken = 0  # when the reader was last looked at

    def look(self) -> None:
        """Something may wait to be sent: the deadline begins, unless it has begun."""
        if self._timer is None and self._transport.get_write_buffer_size():
            self._begin()

    def look_anew(self) -> None:
        """Much waits, or no more. Where the system does not count what is taken, what is written next would hide it."""
        if self._timer is not None and not counts_taken_bytes(self._transport):
            self.end()
        self.look()

    def end(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _begin(self) -> None:
        self._taken = taken_bytes(self._transport)
        self._timer = self._loop.call_later(self._unread_s, self._drop_unless_read)

    def _drop_unless_read(self) -> None:
        self._timer = None
        if not self._transport.get_write_buffer_size():
            return
        if taken_bytes(self._transport) - self._taken < LEAST_READ_PER_S * self._unread_s:
            self._transport.abort()
        else:
            self._begin()
