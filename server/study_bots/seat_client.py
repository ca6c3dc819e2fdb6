"""Plays one seat of a room over the WebSocket, as the game page does."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from movingout.maps import map_from_json
from movingout.server import messages as m
from movingout.server.frames import Bundle, Input
from movingout.server.study_bots.policies import SeatPolicy

OVER_PHASES = ("round_over", "series_over", "closed")
SILENCE_S = 5.0  # longest time without a message; the room sends its state every second


class SeatClient:
    """One connection to a room: until the round is over, the connection breaks or the player leaves."""

    def __init__(self, address: str, room: str, token: str, policy: SeatPolicy, device: str) -> None:
        self._address = address
        self._join = m.Join(room, tokens=[token])
        self._policy = policy
        self._device = m.DEVICES.index(device)
        self._seat = -1
        self._newest: Bundle | None = None
        self._changed = asyncio.Event()
        self.outcome = ""  # of the round, once it is known
        self.left_early = False
        self._round_known = self._over = False
        self._count = self._presses = 0

    async def play(self, drops: Callable[[], bool], max_ticks: int = 0) -> bool:
        """Play, and return whether the round is over.

        Each tick, `drops()` says whether to break the connection; after `max_ticks`, if given, the player leaves.
        """
        with contextlib.suppress(OSError, TimeoutError, WebSocketException):
            options: dict[str, Any] = {"subprotocols": [m.SUBPROTOCOL], "compression": None, "max_queue": None}
            async with connect(f"{self._address}/ws/{self._join.room}", close_timeout=1, **options) as socket:
                await socket.send(msgspec.json.encode(self._join).decode())
                reading = asyncio.create_task(self._read(socket))
                try:
                    await self._steer(socket, reading, drops, max_ticks)
                finally:
                    reading.cancel()
        return self._over

    async def _read(self, socket: ClientConnection) -> None:
        """Handle every message; of the bundles keep only the newest."""
        try:
            async for frame in socket:
                if isinstance(frame, str):
                    await self._handle(socket, msgspec.json.decode(frame))
                elif frame[0] == m.BUNDLE:
                    self._newest = Bundle.decode(frame)
                self._changed.set()
        finally:
            self._changed.set()

    async def _handle(self, socket: ClientConnection, message: dict[str, Any]) -> None:
        match message["type"]:
            case "welcome":
                self._seat = message["seats"][0]["seat"]
            case "round":
                self._policy.begin(map_from_json(message["map"]), self._seat, message["limit_ticks"])
                self._round_known = True
            case "room":
                self._over = self._over or message["phase"] in OVER_PHASES
                waits = message["phase"] in ("lobby", "countdown", "paused")
                if waits and self._seat >= 0 and not message["seats"][self._seat]["ready"]:
                    await socket.send(msgspec.json.encode(m.Ready(self._seat)).decode())
            case "result":
                self._over, self.outcome = True, message["outcome"]

    async def _steer(
        self, socket: ClientConnection, reading: asyncio.Task[None], drops: Callable[[], bool], max_ticks: int
    ) -> None:
        while not (self._over or reading.done()):
            async with asyncio.timeout(SILENCE_S):
                await self._changed.wait()
            self._changed.clear()
            bundle, self._newest = self._newest, None
            if bundle is None or not self._round_known:
                continue
            if max_ticks and bundle.tick >= max_ticks:
                self.left_early = True
                return
            if drops():
                socket.transport.abort()
                return
            with contextlib.suppress(ConnectionClosed):
                await socket.send(self._input(bundle))
            await asyncio.sleep(0)  # lets `_read` take newer bundles first

    def _input(self, bundle: Bundle) -> bytes:
        stick = self._policy.steer(bundle)
        self._count += 1
        self._presses += stick.press
        return Input(
            seat=self._seat,
            seq=self._count,
            ack_tick=bundle.tick,
            seen_tick=bundle.tick,
            move=stick.move,
            heading=stick.heading,
            grabs=self._presses % 256,
            device=self._device,
            client_ms=bundle.time_ms,
        ).encode()
