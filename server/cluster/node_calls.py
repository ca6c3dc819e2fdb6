"""Calls between the nodes of a cluster, over HTTP: signed with the cluster's secret, and typed on both sides.

A call is a function `name(host, ...)` in a table that both nodes have; arguments and result are MessagePack, checked
against the annotations of that function. Nothing is unpickled. The signature covers the run of the node that is asked,
the run of the one that asks, and a number that only grows: nobody can repeat a call that was overheard.
"""

import asyncio
import bisect
import hashlib
import hmac
import inspect
import itertools
import logging
import typing
from collections import OrderedDict
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import msgspec

from movingout.agents.errors import AgentError, AgentsBusyError
from movingout.maps.errors import MovingOutError
from movingout.server.connection.asgi import App, Message, Receive, Send
from movingout.server.public_host import Away, NoRoom

log = logging.getLogger(__name__)

CALL = "/cluster/call/"  # + the name of the function
CALL_S = 3.0
MOST_BYTES = 256 * 1024  # of arguments: a map has some thousand
WINDOW = 4096  # numbers of one caller that may overtake each other
MOST_CALLERS = 200
ERRORS: Mapping[str, type[MovingOutError]] = {
    "no-room": NoRoom, "busy": AgentsBusyError, "agent": AgentError, "away": Away,
}  # fmt: skip
Work = Callable[..., Any]


class NodeError(MovingOutError):
    """What another node answers that it cannot do."""


class CallResult(msgspec.Struct):
    """What a call brings back: a result, or the kind and the sentence of an error."""

    found: msgspec.Raw = msgspec.Raw(b"\xc0")
    error: str = ""
    message: str = ""


def signature(secret: str, called: str, caller: str, number: int, name: str, body: bytes) -> str:
    head = f"{called}\n{caller}\n{number}\n{name}\n".encode()
    return hmac.new(secret.encode(), head + body, hashlib.sha256).hexdigest()


class Numbers:
    """Whether the number of a call is new; of each caller the newest numbers are known, and older ones refused."""

    def __init__(self) -> None:
        self._seen: OrderedDict[str, tuple[list[int], set[int]]] = OrderedDict()

    def is_new(self, caller: str, number: int) -> bool:
        newest, known = self._seen.setdefault(caller, ([0], {0}))
        self._seen.move_to_end(caller)
        if number in known or number < newest[0]:
            return False
        bisect.insort(newest, number)
        known.add(number)
        if len(newest) > WINDOW:
            known.discard(newest.pop(0))
        while len(self._seen) > MOST_CALLERS:
            self._seen.popitem(last=False)
        return True


class NodeCaller:
    """Calls other nodes in the name of this one; `secret` is known once it has joined the cluster."""

    def __init__(self, run: str, secret: Callable[[], str]) -> None:
        self._run, self._secret = run, secret
        self._numbers = itertools.count(1)

    async def call(self, address: str, run: str, work: Work, *args: Any, within_s: float = CALL_S) -> Any:
        """What `work(host, ...)` returns at the node with this address and run. Raises Away and what it raises.

        Of that, errors that the nodes do not know by name are a NodeError.
        """
        body, number = msgspec.msgpack.encode(args), next(self._numbers)
        sign = signature(self._secret(), run, self._run, number, work.__name__, body)
        head = (
            f"POST {CALL}{work.__name__} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n"
            f"content-length: {len(body)}\r\nx-caller: {self._run}\r\nx-number: {number}\r\nx-signature: {sign}\r\n\r\n"
        )
        try:
            async with asyncio.timeout(within_s):
                content = await _exchange(address, head.encode("ascii") + body)
            answer = msgspec.msgpack.decode(content, type=CallResult)
        except (OSError, TimeoutError, EOFError, ValueError, msgspec.MsgspecError) as error:
            raise Away(f"the node at {address} does not answer: {error or type(error).__name__}") from error
        if answer.error:
            raise ERRORS.get(answer.error, NodeError)(answer.message)
        return msgspec.msgpack.decode(answer.found, type=_types(work)[1])


async def _exchange(address: str, request: bytes) -> bytes:
    """The body of the answer to one request on a connection of its own. Raises OSError, EOFError, ValueError."""
    host, _, port = address.rpartition(":")
    reader, writer = await asyncio.open_connection(host.strip("[]"), int(port))
    try:
        writer.write(request)
        await writer.drain()
        head, _, body = (await reader.read(-1)).partition(b"\r\n\r\n")
        if head.split(b" ", 2)[1:2] != [b"200"]:
            raise ValueError(head.split(b"\r\n", 1)[0].decode("latin-1")[:80] or "no answer")
        return body
    finally:
        writer.close()


class NodeCalls:
    """ASGI middleware: does what other nodes call, before anything else looks at the request."""

    def __init__(self, app: App, host: Any, run: str, secret: Callable[[], str], works: tuple[Work, ...]) -> None:
        self._app, self._host, self._run, self._secret = app, host, run, secret
        self._works = {work.__name__: work for work in works}
        self._numbers = Numbers()

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or not scope["path"].startswith(CALL):
            await self._app(scope, receive, send)
            return
        work = self._works.get(scope["path"].removeprefix(CALL))
        body = await _body(receive)
        if work is None or body is None or not self._is_signed(scope, body):
            await _send(send, 404, b"")  # to a stranger there is nothing here
            return
        await _send(send, 200, msgspec.msgpack.encode(await self._answer(work, body)))

    def _is_signed(self, scope: Message, body: bytes) -> bool:
        headers = {name: value.decode("latin-1") for name, value in scope["headers"] if name.startswith(b"x-")}
        caller, number = headers.get(b"x-caller", ""), headers.get(b"x-number", "")
        secret, name = self._secret(), scope["path"].removeprefix(CALL)
        if not secret or not (number.isascii() and number.isdecimal() and len(number) < 16):
            return False
        wanted = signature(secret, self._run, caller, int(number), name, body)
        if not hmac.compare_digest(wanted.encode(), headers.get(b"x-signature", "").encode("latin-1")):
            return False
        return self._numbers.is_new(caller, int(number))

    async def _answer(self, work: Work, body: bytes) -> CallResult:
        try:
            found = work(self._host, *msgspec.msgpack.decode(body, type=_types(work)[0]))
            found = await found if inspect.isawaitable(found) else found
            return CallResult(found=msgspec.Raw(msgspec.msgpack.encode(found)))
        except MovingOutError as error:
            kind = next((name for name, kind in ERRORS.items() if isinstance(error, kind)), "error")
            return CallResult(error=kind, message=str(error))
        except Exception as error:  # a fault of ours, which the node that asked is told of, too
            log.exception("%s failed for another node", work.__name__)
            return CallResult(error="error", message=f"{work.__name__} failed: {type(error).__name__}")


@cache
def _types(work: Work) -> tuple[Any, Any]:
    """Of the arguments after the first, and of the result."""
    hints = typing.get_type_hints(work)
    result = hints.pop("return")
    return tuple[tuple(list(hints.values())[1:])], result  # type: ignore[misc]


async def _body(receive: Receive) -> bytes | None:
    """The body of a request; None for one that is too long."""
    parts, size = [], 0
    while True:
        message = await receive()
        if message["type"] != "http.request":
            return None
        parts.append(message.get("body", b""))
        size += len(parts[-1])
        if size > MOST_BYTES:
            return None
        if not message.get("more_body"):
            return b"".join(parts)


async def _send(send: Send, status: int, body: bytes) -> None:
    """Answer a call and close: no limit on requests holds here, but one on connections."""
    headers = [
        (b"content-length", str(len(body)).encode()),
        (b"content-type", b"application/msgpack"),
        (b"connection", b"close"),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
