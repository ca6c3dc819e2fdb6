"""A seat in a room, played through the websocket as the game page does."""

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

OVER = ("round_over", "series_over", "closed")
SILENCE_S = 5.0  # the room says where it is every second


class SeatClient:
    """One visit to a room: until the round is over, the connection is, or the player has had enough."""

    def __init__(self, address: str, room: str, token: str, policy: SeatPolicy, device: str) -> None:
        self._address = address
        self._join = m.Join(room, tokens=[token])
        self._policy = policy
        self._device = m.DEVICES.index(device)
        self._seat = -1
        self._newest: Bundle | None = None
        self._news = asyncio.Event()
        self.outcome = ""  # of the round, once it is known
        self.had_enough = False
        self._begun = self._over = False
        self._count = self._presses = 0

    async def play(self, drops: Callable[[], bool], enough: int = 0) -> bool:
        """Whether the round is over. `drops`, asked each tick, breaks the connection; `enough` ticks are enough."""
        with contextlib.suppress(OSError, TimeoutError, WebSocketException):
            options: dict[str, Any] = {"subprotocols": [m.SUBPROTOCOL], "compression": None, "max_queue": None}
            async with connect(f"{self._address}/ws", close_timeout=1, **options) as socket:
                await socket.send(msgspec.json.encode(self._join).decode())
                reading = asyncio.create_task(self._read(socket))
                try:
                    await self._steer(socket, reading, drops, enough)
                finally:
                    reading.cancel()
        return self._over

    async def _read(self, socket: ClientConnection) -> None:
        """Take everything that comes, and keep only the newest picture of the game."""
        try:
            async for frame in socket:
                if isinstance(frame, str):
                    await self._hear(socket, msgspec.json.decode(frame))
                elif frame[0] == m.BUNDLE:
                    self._newest = Bundle.decode(frame)
                self._news.set()
        finally:
            self._news.set()

    async def _hear(self, socket: ClientConnection, message: dict[str, Any]) -> None:
        match message["type"]:
            case "welcome":
                self._seat = message["seats"][0]["seat"]
            case "round":
                self._policy.begin(map_from_json(message["map"]), self._seat, message["limit_ticks"])
                self._begun = True
            case "room":
                self._over = self._over or message["phase"] in OVER
                waits = message["phase"] in ("lobby", "countdown", "paused")
                if waits and self._seat >= 0 and not message["seats"][self._seat]["ready"]:
                    await socket.send(msgspec.json.encode(m.Ready(self._seat)).decode())
            case "result":
                self._over, self.outcome = True, message["outcome"]

    async def _steer(
        self, socket: ClientConnection, reading: asyncio.Task[None], drops: Callable[[], bool], enough: int
    ) -> None:
        while not (self._over or reading.done()):
            async with asyncio.timeout(SILENCE_S):
                await self._news.wait()
            self._news.clear()
            bundle, self._newest = self._newest, None
            if bundle is None or not self._begun:
                continue
            if enough and bundle.tick >= enough:
                self.had_enough = True
                return
            if drops():
                socket.transport.abort()
                return
            with contextlib.suppress(ConnectionClosed):
                await socket.send(self._input(bundle))
            await asyncio.sleep(0)  # what came meanwhile is newer

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
