"""One connected client: its join, what it says, and what its room sends to it."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable
from typing import TypeVar

import msgspec

from movingout.server import messages as m
from movingout.server.connection import control_messages
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import DirectSocket, Receive, Send, send_frame
from movingout.server.connection.closing import CloseConnection, closing_of, not_understood, say_goodbye
from movingout.server.connection.send_queue import SendQueue
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.frame_layout import FrameError
from movingout.server.frames import Ping, Pong, decode_client_frame
from movingout.server.notices import Notice
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room import Room
from movingout.server.rooms.services import Refused, WrongRequest
from movingout.server.settings import Limits

log = logging.getLogger(__name__)

Parsed = TypeVar("Parsed")
Said = TypeVar("Said")
Kept = Callable[[], Awaitable[None]]
STATES_S = 0.2  # from one whole state that a client asks for to the next
KEPT_S = 2.0  # that a welcome waits for: with a disk that hangs people play on

LOCKED = Notice("locked", "Too many wrong keys from your address; wait a minute.")

# A slow line or a busy server, perhaps: who comes again may be quicker.
LATE = Notice("bad_request", "The first message must be a join, within 5 seconds.")

_decode_control = msgspec.json.Decoder(m.ClientMessage).decode
_decode_join = msgspec.json.Decoder(m.Join).decode


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
        self._next_state_at = 0.0
        self._state_due: asyncio.TimerHandle | None = None
        self._closing: CloseConnection | None = None  # raised in a callback, where nothing catches it
        self.client = SendQueue(wire.write, self._wake.set)

    async def send_all(self, send: Send) -> None:
        """Send what the queue holds until the connection is to be closed. Raises CloseConnection then."""
        client = self.client
        while True:
            await self._wake.wait()
            self._wake.clear()
            while not client.lost and (frame := client.next_frame()) is not None:
                client.blocked_since = client.blocked_since or time.monotonic()
                await send_frame(send, frame)
                client.blocked_since = 0.0
                client.bytes_sent += len(frame)
            if self._closing is not None:
                raise self._closing
            if client.lost:
                raise CloseConnection(0)
            if client.goodbye is not None:
                raise CloseConnection(*client.goodbye)

    async def listen(self, receive: Receive) -> None:
        """Receive the join, then one message after another. Raises CloseConnection when it ends."""
        try:
            await asyncio.wait_for(self._join(receive), self._limits.join_s)
        except TimeoutError:
            raise CloseConnection(m.CLOSE_RETRY_LATER, LATE) from None
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
        closing = closing_of(listener) or closing_of(sender) or CloseConnection(0)
        sender.cancel()
        listener.cancel()
        await asyncio.gather(sender, listener, return_exceptions=True)
        self._wire.stop_listening()
        if self._state_due is not None:
            self._state_due.cancel()
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
            await send_frame(send, frame)
        await say_goodbye(send, closing)

    # ---- what the client says -------------------------------------------------------------------------------

    async def _join(self, receive: Receive) -> None:
        message = await receive()
        if message["type"] != "websocket.receive":
            raise CloseConnection(0)
        if message.get("text") is None:
            raise not_understood("The first message must be a join (JSON text).")
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
        per_s = self._limits.messages_per_s * len(welcome.seats) or self._limits.watcher_messages_per_s
        self._bucket = TokenBucket(per_s, max(per_s, self._limits.message_burst), time.monotonic())
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
            raise not_understood(str(error)) from None
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
        if isinstance(message, m.Keyframe):
            self._ask_state(now)
        else:
            self._attempt(control_messages.handle, message, now)

    def _ask_state(self, now: float) -> None:
        """The whole state, now or as soon as the last one is old enough; who asks again meanwhile is answered by it."""
        if self._state_due is None and now >= self._next_state_at:
            self._tell_state()
        elif self._state_due is None:
            self._state_due = asyncio.get_running_loop().call_later(self._next_state_at - now, self._tell_state)

    def _tell_state(self) -> None:
        now = time.monotonic()
        self._state_due, self._next_state_at = None, now + STATES_S
        self._attempt(control_messages.handle, m.Keyframe(), now)

    def _attempt(self, request: Callable[[Room, SendQueue, Said, float], None], said: Said, now: float) -> None:
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


def _parse(decode: Callable[[str], Parsed], text: str) -> Parsed:
    try:
        return decode(text)
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise not_understood(f"This message is not understood: {error}") from None
