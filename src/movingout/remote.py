"""A client for programs that take a seat on a running server: states in, chunks of actions out.

    async with Client("http://127.0.0.1:8000", room="wmud8yzry4je") as client:
        async for observation in client.observations():     # ten a second, the newest where some were missed
            client.act(my_policy(observation.encode("map-v1")))

Answers may be late: the last chunk is played on meanwhile, row by row, and then the robot stands still.
docs/protocol.md explains the messages underneath.
"""

import asyncio
import contextlib
import json
import ssl
from collections.abc import AsyncIterator
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import quote, urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from movingout.maps import MapSpec, MovingOutError

if TYPE_CHECKING:  # NumPy and the world, loaded by `__aenter__`: an import of this module costs little
    import numpy.typing as npt

    from movingout.agents.base import Agent, Observation
    from movingout.remote_seat import RemoteSeat

SUBPROTOCOL = "movingout.v1"
BUNDLE = 1  # type of a frame
OVER = ("series_over", "closed")  # phases without a further round
_LEFT = "the server has closed the connection"
_SERIES_OVER = "the series is over"


class RemoteError(MovingOutError):
    """The server cannot be reached, refuses, or has closed the connection; the message is the server's."""


@dataclass(frozen=True, slots=True)
class RoundResult:
    """How a round ended."""

    outcome: str  # delivered, time, left, stopped, error
    ticks: int
    metrics: dict[str, float]  # by key (docs/metrics.md), -1 for none
    recording: str  # the episode's id, empty where it was not recorded


class Client:
    """One seat in one room, for a series of rounds. Made for one event loop; not for several threads."""

    def __init__(
        self,
        server: str,
        room: str,
        *,
        name: str = "program",
        token: str = "",
        certificates: ssl.SSLContext | None = None,
    ) -> None:
        """`server`: its address, http(s) or ws(s). `token`: of an earlier connection, to come back to its seat.

        `certificates`: which of them to trust, for a server with a self-signed one. Raises RemoteError for an
        address that is none.
        """
        self._address, self._room, self._name, self.token = _websocket(server, room), room, name, token
        self._tls = certificates or True if self._address.startswith("wss:") else None
        self.seat = -1  # 0 blue, 1 red, from `__aenter__` on
        self.result: RoundResult | None = None  # of the last round
        self._player: RemoteSeat | None = None  # from `__aenter__` on
        self._arrived = asyncio.Event()
        self._phase = self._reason = self._refused = self._closed = ""

    @property
    def map(self) -> MapSpec | None:
        """The map of the coming or running round; None before the server has said it."""
        return self._player.map if self._player else None

    @property
    def limit_ticks(self) -> int:
        """The ticks that the coming or running round lasts at most; 0 before the server has said it."""
        return self._player.limit_ticks if self._player else 0

    async def __aenter__(self) -> Self:
        from movingout.remote_seat import RemoteSeat

        try:
            self._socket = await connect(
                self._address,
                subprotocols=[SUBPROTOCOL],  # type: ignore[list-item]
                ssl=self._tls,
            )
            seats = {"tokens": [self.token]} if self.token else {"claim": 1}
            await self._tell("join", room=self._room, program=True, name=self._name, **seats)
            welcome = json.loads(await self._socket.recv())
        except (OSError, WebSocketException) as error:
            raise RemoteError(f"cannot connect to {self._address}: {error}") from error
        if welcome["type"] != "welcome" or not welcome["seats"]:
            await self._socket.close()
            raise RemoteError(welcome.get("message", "the room has no open seat for a program"))
        self.seat, self.token = welcome["seats"][0]["seat"], welcome["seats"][0]["token"]
        self._player = RemoteSeat(self.seat, welcome["frames"])
        self._reader = asyncio.create_task(self._read(self._socket))
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._reader.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._reader
        await self._socket.close()

    async def observations(self) -> AsyncIterator["Observation"]:
        """Say ready, and give the newest state of the coming round until it ends; `result` tells how.

        Raises RemoteError when the server refuses or closes the connection, or the series ends without a result.
        """
        self.result, self._refused = None, ""
        self._seated.wait_for_round()
        await self._tell("ready", seat=self.seat)
        while not self._ended():
            await self._arrived.wait()
            self._arrived.clear()
            if self.result is None and not self.over and self._seated.newest is not None:
                yield self._seated.newest

    def _ended(self) -> bool:
        """Whether the round is over and the room has said what follows. Raises RemoteError when no result will come."""
        if self.result is not None:
            return bool(self._phase or self._closed)
        if why := self._closed or self._refused or (self.over and (self._reason or _SERIES_OVER)):
            raise RemoteError(why)
        return False

    def act(self, chunk: "npt.ArrayLike") -> None:
        """Play a chunk (H, 4) from now on, one row per tick: distance, cos and sin of the heading, grasp toggle.

        It replaces the rest of the last one; a press that was sent is not taken back. Raises AgentError.
        """
        self._seated.play(chunk)
        self._send_row()

    async def play(self, agent: "Agent", seed: int = 0) -> RoundResult:
        """Let an agent play a round, in a thread of its own: `reset`, then `act` whenever its last chunk is used up.

        As in matches, these are all its rows, or as many as the agent's `execute_rows` says; unlike there, its first
        observation is that of tick 1, before which its robot stood still. Raises RemoteError, AgentError for a wrong
        chunk, and what the agent raises.
        """
        if isinstance(agent, str | type) or not (hasattr(agent, "reset") and hasattr(agent, "act")):
            raise RemoteError(f"an agent is an object with reset() and act(), as of load_agent(…), not {agent!r:.80}")
        from movingout.agents.action_chunk import checked_chunk, rows_to_execute

        started, due = False, 0
        async for observation in self.observations():
            if not started:
                await asyncio.to_thread(agent.reset, self._seated.episode(seed))
                started = True
            if observation.tick >= due:
                chunk = await asyncio.to_thread(agent.act, observation)
                self.act(chunk)
                due = self._seated.tick + rows_to_execute(agent, checked_chunk(chunk))
        assert self.result is not None
        return self.result

    @property
    def over(self) -> bool:
        """Whether the series has no further round."""
        return bool(self._closed) or self._phase in OVER

    @property
    def _seated(self) -> "RemoteSeat":
        """What plays the seat. Raises RemoteError outside `async with`."""
        if self._player is None:
            raise RemoteError("the client is not connected; write `async with Client(...) as client:` around it")
        return self._player

    async def _tell(self, kind: str, **fields: object) -> None:
        with contextlib.suppress(ConnectionClosed):  # the reader says why
            await self._socket.send(json.dumps({"type": kind, **fields}))

    async def _read(self, socket: ClientConnection) -> None:
        try:
            async for message in socket:
                if isinstance(message, str):
                    self._take_message(json.loads(message))
                elif message[0] == BUNDLE:
                    self._take_bundle(message)
            self._closed = self._closed or _LEFT
        except ConnectionClosed:
            self._closed = self._closed or _LEFT
        except Exception as error:  # noqa: BLE001 - a message of another version, or none: a program would wait for ever
            self._closed = f"cannot read what the server says: {type(error).__name__}: {error}"
        finally:
            self._arrived.set()

    def _take_message(self, message: dict[str, Any]) -> None:
        match message["type"]:
            case "round":
                self._seated.begin(message)
            case "room":
                self._phase, self._reason = message["phase"], message["reason"]
                if self.result is not None or self.over:
                    self._arrived.set()
            case "error" if self._phase != "playing":  # in a round that runs, nobody needs to be ready
                self._refused = message["message"]
                self._arrived.set()
            case "result":
                self._phase = ""  # `room` follows, and says whether another round does
                metrics = message.get("metrics", {})
                self.result = RoundResult(message["outcome"], message["ticks"], metrics, message["recording"])
            case "ping":
                self._seated.take_ping(message)
            case "bye":
                self._closed = message["message"]

    def _take_bundle(self, frame: bytes) -> None:
        """Note the state after the tick, and play the next row of a chunk that is not over."""
        if self._seated.take_bundle(frame):
            self._send_row()
        if self._seated.newest is not None:
            self._arrived.set()

    def _send_row(self) -> None:
        self._sending = asyncio.ensure_future(self._send(self._seated.next_input()))

    async def _send(self, frame: bytes) -> None:
        with contextlib.suppress(ConnectionClosed):  # the reader says why
            await self._socket.send(frame)


def _websocket(server: str, room: str) -> str:
    """The address of a room's websocket. Raises RemoteError for what is no address of a server."""
    schemes = {"http": "ws", "https": "wss", "ws": "ws", "wss": "wss"}
    parts = urlsplit(server)
    if parts.scheme not in schemes or not parts.netloc:
        raise RemoteError(f"{server!r} is no address of a server; write http://127.0.0.1:8000")
    before = parts.path.removesuffix("/ws").rstrip("/")
    return f"{schemes[parts.scheme]}://{parts.netloc}{before}/ws/{quote(room, safe='')}"
