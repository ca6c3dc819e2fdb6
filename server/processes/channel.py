"""Calls between two processes of one server, over a socket that a parent and its child inherit.

Functions and values are pickled, so the socket must have no name: nobody else can reach it.
"""

import asyncio
import contextlib
import inspect
import itertools
import logging
import pickle
import socket
import struct
import sys
from collections.abc import Callable
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from movingout.maps.errors import MovingOutError
from movingout.server.public_host import Away

log = logging.getLogger(__name__)

_LENGTH = struct.Struct("<I")
Here = TypeVar("Here")
There = TypeVar("There")
Given = ParamSpec("Given")
Found = TypeVar("Found")
First = TypeVar("First")


def first_message(link: socket.socket, kind: type[First]) -> First:
    """What the other end `greet`s with; the socket blocks until it is there. Ends this process when none comes."""
    link.setblocking(True)
    (size,) = _LENGTH.unpack(_exactly(link, _LENGTH.size))
    message = pickle.loads(_exactly(link, size))
    assert isinstance(message, kind)
    return message


def _exactly(link: socket.socket, size: int) -> bytes:
    parts = b""
    while len(parts) < size:
        data = link.recv(size - len(parts))
        if not data:
            sys.exit(0)  # the other end has gone already
        parts += data
    return parts


class ProcessGone(Away):
    """The process at the other end has ended."""


class Channel(Generic[Here, There]):
    """Calls functions of the form `work(there, ...)` at the other end, with its `there`, and serves those of the other.

    First `open`; then `serve` runs until the other end closes.
    """

    def __init__(self, link: socket.socket, here: Here) -> None:
        self._link = link
        self._here = here
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None
        self._numbers = itertools.count(1)
        self._open: dict[int, asyncio.Future[Any]] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def open(self) -> None:
        self._reader, self._writer = await asyncio.open_connection(sock=self._link)

    async def serve(self) -> None:
        """Answer calls until the other end closes; calls still open then raise ProcessGone."""
        reader = self._reader
        assert reader is not None
        try:
            while True:
                (size,) = _LENGTH.unpack(await reader.readexactly(_LENGTH.size))
                self._take(pickle.loads(await reader.readexactly(size)))
        except (asyncio.IncompleteReadError, ConnectionError):
            pass
        finally:
            self.close()

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        for waiting in self._open.values():
            if not waiting.done():
                waiting.set_exception(ProcessGone("the process of this room has ended"))
        self._open.clear()

    async def call(
        self, work: Callable[Concatenate[There, Given], Any], *args: Given.args, **kwargs: Given.kwargs
    ) -> Any:
        """What `work(there, ...)` returns or raises at the other end. Raises ProcessGone."""
        number = next(self._numbers)
        self._open[number] = asyncio.get_running_loop().create_future()
        try:
            self._send((number, work, args, kwargs))
            return await self._open[number]
        finally:
            self._open.pop(number, None)

    def tell(self, work: Callable[Concatenate[There, Given], Any], *args: Given.args, **kwargs: Given.kwargs) -> None:
        """Have `work(there, ...)` done at the other end; nothing comes back, and nothing happens when it is gone."""
        with contextlib.suppress(ProcessGone):
            self._send((0, work, args, kwargs))

    def greet(self, message: object) -> None:
        """Send the first message of all, which the other end awaits before it serves."""
        self._write(pickle.dumps(message))

    def _send(self, message: tuple[Any, ...]) -> None:
        if self._writer is None or self._writer.is_closing():
            raise ProcessGone("the process of this room has ended")
        self._write(pickle.dumps(message))

    def _write(self, body: bytes) -> None:
        assert self._writer is not None
        self._writer.write(_LENGTH.pack(len(body)) + body)

    def _take(self, message: tuple[Any, ...]) -> None:
        if len(message) == 3:
            self._take_answer(*message)
            return
        task = asyncio.create_task(self._answer(*message))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _take_answer(self, number: int, worked: bool, found: Any) -> None:
        waiting = self._open.get(number)
        if waiting is None or waiting.done():
            return
        if worked:
            waiting.set_result(found)
        else:
            waiting.set_exception(found)

    async def _answer(
        self, number: int, work: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> None:
        worked: bool = True
        try:
            found = work(self._here, *args, **kwargs)
            found = await found if inspect.isawaitable(found) else found
        except Exception as error:  # raised at the other end, where somebody waits for it
            if number == 0 or not isinstance(error, MovingOutError):
                log.exception("%s failed", work.__name__)
            worked, found = False, error
        if number:
            with contextlib.suppress(ProcessGone):
                self._send((number, worked, found))
