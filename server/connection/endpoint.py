"""The websocket endpoint: connects one client, from handshake to close, with its room.

Written against plain ASGI, because the hot path is one decode and one call. On abuse the connection is dropped without
a close frame: otherwise Uvicorn would go on parsing what the client sends for ten seconds.
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any, Protocol, TypeVar

import msgspec

from movingout.server import messages as m
from movingout.server.connection import control_messages
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.hosts import host_allowed
from movingout.server.connection.origin import origin_allowed
from movingout.server.connection.send_queue import Client
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.frame_layout import FrameError
from movingout.server.frames import Ping, Pong, decode_client_frame
from movingout.server.notices import NOTHING, Notice
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTARTING
from movingout.server.rooms.services import Refused, WrongRequest
from movingout.server.settings import Limits, Settings

log = logging.getLogger(__name__)

Parsed = TypeVar("Parsed")
Said = TypeVar("Said")
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]
OnBinary = Callable[[bytes], bool]  # False: the connection is closing
Kept = Callable[[], Awaitable[None]]
KEPT_S = 2.0  # that a welcome waits for: with a disk that hangs people play on
WIRE = "movingout.wire"  # where the scope's extensions hold the DirectSocket of a connection

LOCKED = Notice("locked", "Too many wrong keys from your address; wait a minute.")
NO_ROOM = Notice("no_room", "This room no longer exists. Start a new game.")
FAILED = Notice("connection_failed", "Something went wrong with this connection.")

_decode_control = msgspec.json.Decoder(m.ClientMessage).decode
_decode_join = msgspec.json.Decoder(m.Join).decode


class DirectSocket(Protocol):
    """A connection without ASGI's queues (server.connection.uvicorn_protocols.GameWebSocketProtocol)."""

    def listen(self, on_binary: OnBinary, on_writable: Callable[[], None]) -> None:
        """Pass every small binary message to `on_binary`; call `on_writable` when more can be written."""

    def stop_listening(self) -> None: ...

    def write(self, message: str | bytes) -> bool: ...

    def abort(self) -> None: ...

    def hand_over(self, give: Callable[[int, bytes], None]) -> bool: ...


class CloseConnection(Exception):
    """Ends the connection with a close code and a notice; 0 drops the connection without a word."""

    def __init__(self, code: int, notice: Notice = NOTHING) -> None:
        super().__init__(notice.message)
        self.code = code
        self.notice = notice


def no_room(room_id: str) -> CloseConnection:
    """How a connection ends whose room is not here."""
    return CloseConnection(m.CLOSE_NOT_FOUND, NO_ROOM)


async def _at_once() -> None:
    """Nothing is kept."""


class SocketEndpoint:
    """The ASGI application behind /ws and /ws/ROOM."""

    def __init__(
        self, settings: Settings, registry: RoomRegistry, admission: AdmissionControl, kept: Kept = _at_once
    ) -> None:
        """`kept` waits until a restart would bring back what rooms are now."""
        self._kept = kept
        self.absence: Callable[[str], CloseConnection] = no_room
        self._settings = settings
        self._registry = registry
        self._admission = admission
        self.stopping = False  # who comes now is told to come back
        self.open: set[ClientConnection] = set()
        self._bytes_sent = 0  # to clients that have left

    def total_bytes_sent(self) -> int:
        return self._bytes_sent + sum(each.client.bytes_sent for each in self.open)

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        await receive()  # websocket.connect
        address = scope["client"][0] if scope.get("client") else ""
        refusal = handshake_refusal(self._settings, scope) or ((503, self._admission.enter(address)))
        if refusal[1]:
            self._admission.refusals["socket"] += 1
            await refuse(send, *refusal)
            return
        try:
            await send({"type": "websocket.accept", "subprotocol": m.SUBPROTOCOL})
            wire: DirectSocket = scope["extensions"][WIRE]
            if self.stopping:
                await say_goodbye(send, CloseConnection(m.CLOSE_SHUTDOWN, RESTARTING))
                return
            connection = ClientConnection(
                self._settings.limits, self._registry, self._admission, wire, address, self.absence, self._kept
            )
            await self._serve(connection, receive, send)
        finally:
            self._admission.leave(address)

    async def _serve(self, connection: "ClientConnection", receive: Receive, send: Send) -> None:
        self.open.add(connection)
        sender = asyncio.create_task(connection.send_all(send))
        listener = asyncio.create_task(connection.listen(receive))
        try:
            await asyncio.wait((sender, listener), return_when=asyncio.FIRST_COMPLETED)
            await connection.end(sender, listener, send)
        finally:
            self._bytes_sent += connection.client.bytes_sent
            self.open.discard(connection)
            connection.leave()


def handshake_refusal(settings: Settings, scope: Message) -> tuple[int, str] | None:
    """The status and the sentence with which a handshake is refused, whatever its address; None for none."""
    if not host_allowed(scope["headers"], settings):
        return 421, "This server does not answer under that name; see --allow-host."
    scheme = "https" if scope["scheme"] == "wss" else "http"
    if not origin_allowed(scope["headers"], scheme, settings.origins):
        return 403, "This page may not talk to this server: its address is not the server's own (see --origin)."
    if m.SUBPROTOCOL not in scope["subprotocols"]:
        return 400, f"This server speaks {m.SUBPROTOCOL}; reload the page, or update the program."
    return None


class ClientConnection:
    """One connected client. `absence` says how it ends when its room is not here."""

    def __init__(
        self,
        limits: Limits,
        registry: RoomRegistry,
        admission: AdmissionControl,
        wire: DirectSocket,
        address: str,
        absence: Callable[[str], CloseConnection],
        kept: Kept,
    ) -> None:
        self._absence = absence
        self._kept = kept
        self._limits = limits
        self._wire = wire
        self._registry = registry
        self._admission = admission
        self._address = address
        self._wake = asyncio.Event()
        self._room: Room | None = None
        self._seats = 0
        self._confirmed = False
        self._bucket = TokenBucket(self._limits.messages_per_s, self._limits.message_burst, time.monotonic())
        self._closing: CloseConnection | None = None  # raised in a callback, where nothing catches it
        self.client = Client(wire.write, self._wake.set)

    async def send_all(self, send: Send) -> None:
        """Send what the queue holds until the connection is to be closed."""
        client = self.client
        while True:
            await self._wake.wait()
            self._wake.clear()
            while not client.lost and (frame := client.next_frame()) is not None:
                client.blocked_since = client.blocked_since or time.monotonic()
                await _send(send, frame)
                client.blocked_since = 0.0
                client.bytes_sent += len(frame)
            if self._closing is not None:
                raise self._closing
            if client.lost:
                raise CloseConnection(0)
            if client.goodbye is not None:
                raise CloseConnection(*client.goodbye)

    async def listen(self, receive: Receive) -> None:
        """Receive the join, then one message after another."""
        try:
            await asyncio.wait_for(self._join(receive), self._limits.join_s)
        except TimeoutError:
            raise _not_understood("The first message must be a join, within 5 seconds.") from None
        finally:
            self._admission.joined(self._address)
        self._wire.listen(self._on_binary, self._wake.set)
        while True:
            message = await receive()
            if message["type"] != "websocket.receive":
                raise CloseConnection(0)
            if message.get("text") is not None:
                self._take_control(message["text"])
            else:  # fragmented, or sent while joining
                self._on_binary(message["bytes"])

    async def end(self, sender: "asyncio.Task[None]", listener: "asyncio.Task[None]", send: Send) -> None:
        """Close the connection: with a message where one is due and can be sent, else at once."""
        closing = _closing_of(listener) or _closing_of(sender) or CloseConnection(0)
        sender.cancel()
        listener.cancel()
        await asyncio.gather(sender, listener, return_exceptions=True)
        self._wire.stop_listening()
        if closing.code == 0 or self.client.blocked_since or self.client.lost:
            self._wire.abort()
            return
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._send_goodbye(closing, send), 1.0)

    def leave(self) -> None:
        if self._room is not None:
            self._room.depart(self.client, time.monotonic())

    async def _send_goodbye(self, closing: CloseConnection, send: Send) -> None:
        while (frame := self.client.next_frame()) is not None:
            await _send(send, frame)
        await say_goodbye(send, closing)

    # ---- what the client says -------------------------------------------------------------------------------

    async def _join(self, receive: Receive) -> None:
        message = await receive()
        if message["type"] != "websocket.receive":
            raise CloseConnection(0)
        if message.get("text") is None:
            raise _not_understood("The first message must be a join (JSON text).")
        request = _parse(_decode_join, message["text"])
        room = self._registry.rooms.get(request.room)
        if room is None:
            raise self._absence(request.room)
        await self._enter(room, request)

    async def _enter(self, room: Room, request: m.Join) -> None:
        self.client.acknowledges = request.mode == "play"
        self.client.hold()
        try:
            welcome = room.join(self.client, request, time.monotonic())
        except Refused as refusal:
            raise CloseConnection(refusal.code, await self._refused(room, request) or refusal.notice) from None
        self._room = room
        per_s = self._limits.messages_per_s * max(1, len(welcome.seats))
        self._bucket = TokenBucket(per_s, per_s, time.monotonic())
        if welcome.seats:  # a server that dies now knows the new tokens when it is back
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._kept(), KEPT_S)
        self.client.release()

    async def _refused(self, room: Room, request: m.Join) -> Notice | None:
        """Count a guessed key; an older one of the same seat is none."""
        guessed = [token for token in request.tokens if not room.seating.was_token(token)]
        return LOCKED if guessed and await self._admission.guesses_too_often(self._address, "seat") else None

    def _on_binary(self, raw: bytes) -> bool:
        """Called by the protocol, so nothing is raised; False when the connection is closing."""
        if self._closing is None:
            try:
                self._take_frame(raw, time.monotonic())
            except CloseConnection as closing:
                self._closing = closing
                self._wake.set()
                if closing.code == 0:
                    self._wire.abort()
        return self._closing is None

    def _take_frame(self, raw: bytes, now: float) -> None:
        self._count_message(now)
        try:
            frame = decode_client_frame(raw)
        except FrameError as error:
            raise _not_understood(str(error)) from None
        if isinstance(frame, Ping):
            self.client.answer(Pong(client_ms=frame.client_ms, server_ms=now * 1e3).encode())
            return
        self._confirm()
        self._attempt(Room.take_input, frame, now)

    def _take_control(self, text: str) -> None:
        now = time.monotonic()
        self._count_message(now)
        self._confirm()
        message = _parse(_decode_control, text)
        self._attempt(control_messages.handle, message, now)

    def _attempt(self, request: Callable[[Room, Client, Said, float], None], said: Said, now: float) -> None:
        if self._room is None:
            return
        try:
            request(self._room, self.client, said, now)
        except WrongRequest as error:
            self.client.tell(m.Problem(error.code, str(error)))

    def _confirm(self) -> None:
        """Any message but a ping proves that the welcome and its tokens have arrived."""
        if not self._confirmed and self._room is not None:
            self._confirmed = True
            self._room.seating.confirm(self.client)

    def _count_message(self, now: float) -> None:
        if not self._bucket.take(now):
            if self._admission.flooded(self._address):
                log.warning("a client sent too many messages and was cut off")
            raise CloseConnection(0)


def _not_understood(message: str) -> CloseConnection:
    return CloseConnection(m.CLOSE_BAD_MESSAGE, Notice("bad_request", message))


def _parse(decode: Callable[[str], Parsed], text: str) -> Parsed:
    try:
        return decode(text)
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise _not_understood(f"This message is not understood: {error}") from None


def _closing_of(task: "asyncio.Task[None]") -> CloseConnection | None:
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


async def _send(send: Send, frame: str | bytes) -> None:
    await send({"type": "websocket.send", "text" if isinstance(frame, str) else "bytes": frame})


async def say_goodbye(send: Send, closing: CloseConnection) -> None:
    """Close an accepted connection with a code and the reason."""
    notice = closing.notice
    bye = m.Bye(code=closing.code, message=notice.message, error=notice.code, values=notice.values)
    await send({"type": "websocket.send", "text": msgspec.json.encode(bye).decode()})
    await send({"type": "websocket.close", "code": closing.code})


async def refuse(send: Send, status: int, sentence: str) -> None:
    """Answer a handshake with an error."""
    body = sentence.encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "websocket.http.response.start", "status": status, "headers": headers})
    await send({"type": "websocket.http.response.body", "body": body})
