"""Lightweight clients for load tests: they speak the real protocol and check that no tick is missing.

A client costs a fraction of a full websocket library, so that one process can run hundreds without becoming the
bottleneck.
"""

import asyncio
import base64
import itertools
import math
import os
import struct
import time
from dataclasses import dataclass, field
from typing import cast

import msgspec

from movingout.server import messages as m
from movingout.server.frames import Bundle, Input, Ping

TEXT, BINARY, CLOSE, WS_PING, WS_PONG = 1, 2, 8, 9, 10
_TICK_AT, _TIME_AT = (Bundle.layout.offsets()[name] for name in ("tick", "time_ms"))


@dataclass
class LoadCounts:
    """What all clients together have counted."""

    bundles: int = 0
    gaps: int = 0  # ticks that a client never received
    closed: dict[int, int] = field(default_factory=dict)  # close codes
    playing: int = 0
    delays_ms: list[float] = field(default_factory=list)  # from the tick's due time to its arrival, same machine


class LoadClient(asyncio.Protocol):
    """One client: joins, is ready at once, then moves its stick in circles."""

    def __init__(self, room: str, mode: m.Mode, tally: LoadCounts, host: str, inputs_per_s: float) -> None:
        self._inputs_per_s = inputs_per_s
        self._room = room
        self._mode = mode
        self._tally = tally
        self._host = host
        self._transport: asyncio.Transport | None = None
        self._buffer = b""
        self._open = False
        self._seats: list[int] = []
        self._tick = 0
        self._measured = False
        self._counter = itertools.count(1)
        self._task: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._transport.write(handshake(self._host, self._room))

    def connection_lost(self, exc: Exception | None) -> None:
        if self._task is not None:
            self._task.cancel()

    def data_received(self, data: bytes) -> None:
        """Raises ConnectionError where the server refuses the connection."""
        self._buffer += data
        if not self._open:
            head, found, rest = self._buffer.partition(b"\r\n\r\n")
            if not found:
                return
            if b" 101 " not in head.split(b"\r\n", 1)[0]:
                raise ConnectionError(head.decode("latin-1") + rest.decode("latin-1"))
            self._open, self._buffer = True, rest
            claim = 1 if self._mode == "play" else 0
            self._say(m.Join(self._room, self._mode, claim=claim, name="bot", program=True))
        self._take_frames()

    def cancel(self) -> None:
        """Close the connection."""
        if self._transport is not None:
            self._transport.close()

    def measure(self) -> None:
        """Count gaps and delays from now on."""
        self._measured = True

    def check(self) -> None:
        """Raises what has ended its play, if that was no closed connection."""
        if self._task is not None and self._task.done() and not self._task.cancelled():
            self._task.result()

    def _take_frames(self) -> None:
        """Server frames are unmasked and never fragmented."""
        buffer, at = self._buffer, 0
        while len(buffer) - at >= 2:
            length, start = buffer[at + 1], at + 2
            if length == 126:
                if len(buffer) < at + 4:
                    break
                length, start = int.from_bytes(buffer[at + 2 : at + 4], "big"), at + 4
            if len(buffer) < start + length:
                break
            self._take(buffer[at] & 15, buffer[start : start + length])
            at = start + length
        self._buffer = buffer[at:]

    def _take(self, opcode: int, payload: bytes) -> None:
        if opcode == BINARY:
            if payload[0] == m.BUNDLE:
                self._take_bundle(payload)
        elif opcode == TEXT:
            self._hear(msgspec.json.decode(payload))
        elif opcode == WS_PING:
            self._send(WS_PONG, payload)
        elif opcode == CLOSE:
            code = int.from_bytes(payload[:2], "big")
            self._tally.closed[code] = self._tally.closed.get(code, 0) + 1

    def _take_bundle(self, payload: bytes) -> None:
        (tick,) = struct.unpack_from("<I", payload, _TICK_AT)
        if self._measured:
            self._tally.bundles += 1
            self._tally.gaps += max(0, tick - self._tick - 1)
            (due_ms,) = struct.unpack_from("<d", payload, _TIME_AT)
            self._tally.delays_ms.append(time.monotonic() * 1e3 - due_ms)
        self._tick = tick

    def _hear(self, message: dict[str, object]) -> None:
        if message["type"] == "welcome":
            self._seats = [grant["seat"] for grant in message["seats"]]  # type: ignore[attr-defined]
            for seat in self._seats:
                self._say(m.Ready(seat))
            self._task = asyncio.create_task(self._play())
        elif message["type"] == "room" and message["phase"] == "playing" and not self._tick:
            self._tally.playing += 1
            self._tick = -1

    async def _play(self) -> None:
        """Send inputs at the chosen rate on an absolute schedule, and a ping each second."""
        period = 1.0 / self._inputs_per_s
        due = time.monotonic() + period * (id(self) % 97) / 97
        while True:
            due += period
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            count = next(self._counter)
            for seat in self._seats:
                tick = max(0, self._tick)
                angle = math.remainder(count * period + seat, 2 * math.pi)
                stick = Input(
                    seat=seat,
                    seq=count,
                    ack_tick=tick,
                    seen_tick=tick,
                    move=1.0,
                    heading=angle,
                    grabs=count // 30 % 256,
                    device=m.DEVICES.index("program"),
                    client_ms=due * 1e3,
                )
                self._send(BINARY, stick.encode())
            if count % max(1, round(self._inputs_per_s)) == 0:
                self._send(BINARY, Ping(client_ms=due * 1e3).encode())

    def _say(self, message: m.ClientMessage) -> None:
        self._send(TEXT, msgspec.json.encode(message))

    def _send(self, opcode: int, payload: bytes) -> None:
        if self._transport is not None:
            self._transport.write(masked(opcode, payload))


def handshake(host: str, room: str) -> bytes:
    """The HTTP request that opens a websocket to a room with our subprotocol."""
    key = base64.b64encode(os.urandom(16)).decode()
    return (
        f"GET /ws/{room} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: {m.SUBPROTOCOL}\r\n\r\n"
    ).encode()


def masked(opcode: int, payload: bytes) -> bytes:
    """A client frame of up to 64 kB. It must be masked; a mask of zeros is allowed and costs nothing."""
    size = len(payload)
    length = bytes((0x80 | size,)) if size < 126 else bytes((0x80 | 126,)) + size.to_bytes(2, "big")
    return bytes((0x80 | opcode,)) + length + b"\0\0\0\0" + payload
