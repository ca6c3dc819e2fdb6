"""A real server on a loopback port in this process, and people who talk to it through real sockets."""

import asyncio
import json
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from movingout.server import messages as m
from movingout.server.app import create_app
from movingout.server.frames import Bundle
from movingout.server.host import Host
from movingout.server.rooms.room import Room
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Limits, Settings
from movingout.server.uvicorn_server import GameServer, game_server, listen
from tests.server.support import make_input

ADMIN = "the-admin-token-of-the-tests"
WAIT_S = 20.0


@dataclass
class Live:
    """A running server."""

    port: int
    host: Host
    loop: asyncio.AbstractEventLoop
    connections: list[ClientConnection] = field(default_factory=list)
    server: GameServer | None = None

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.port}"

    @property
    def rooms(self) -> list[Room]:
        """The rooms of now, copied in one step: the server's own thread opens and removes some meanwhile."""
        return list(self.host.registry.rooms.values())

    def call(
        self, path: str, body: object = None, token: str = "", method: str = "", **headers: str
    ) -> tuple[int, Any]:
        """Status and JSON (or bytes) of a request."""
        data = json.dumps(body).encode() if body is not None else None
        request = urllib.request.Request(f"http://{self.address}{path}", data, method=method or None)
        if token:
            request.add_header("Authorization", f"Bearer {token}")
        for name, value in headers.items():
            request.add_header(name.replace("_", "-"), value)
        try:
            with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
                return answer.status, _content(answer)
        except urllib.error.HTTPError as error:
            with error:
                return error.code, _content(error)

    def open_room(self, *seats: str, maps: tuple[str, ...] = ("Simple",), **config: object) -> dict[str, Any]:
        """Seats are "here", "link", "remote" or an agent's id."""
        known = ("here", "link", "remote")
        kinds = [{"kind": seat} if seat in known else {"kind": "agent", "agent": seat} for seat in seats]
        status, answer = self.call("/api/rooms", {"maps": list(maps), "seats": kinds, **config})
        assert status == 200, answer
        return dict(answer)

    def connect(self, room: str = "", **options: Any) -> ClientConnection:
        connection = connect(
            f"ws://{self.address}/ws/{room}" if room else f"ws://{self.address}/ws",
            subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
            ping_interval=None,
            close_timeout=1,
            **options,
        )
        self.connections.append(connection)
        return connection

    def hang_up(self) -> None:
        """Close what the test has left open."""
        while self.connections:
            self.connections.pop().close()

    def person(self, room: str, **join: object) -> "Person":
        return Person(self.connect(room), room, **join)

    def run(self, work: Any) -> Any:
        """Run a function in the server's thread."""

        async def call() -> Any:
            return work()

        return asyncio.run_coroutine_threadsafe(call(), self.loop).result(WAIT_S)


class Person:
    """One client that speaks the protocol. `told` keeps all control messages."""

    def __init__(self, connection: ClientConnection, room: str, **join: object) -> None:
        self.connection = connection
        self.told: list[dict[str, Any]] = []
        self.bundles: list[Bundle] = []
        self.seq = 0
        self.say(type="join", room=room, **join)
        self.welcome = self.wait_for("welcome")

    @property
    def tokens(self) -> list[str]:
        return [grant["token"] for grant in self.welcome["seats"]]

    def say(self, **message: object) -> None:
        self.connection.send(json.dumps(message))

    def push(self, seat: int = 0, move: float = 0.5, heading: float = 0.0, grabs: int = 0) -> None:
        self.seq += 1
        tick = self.bundles[-1].tick if self.bundles else 0
        self.connection.send(
            make_input(
                seat=seat,
                seq=self.seq,
                ack_tick=tick,
                seen_tick=tick,
                move=move,
                heading=heading,
                grabs=grabs,
                device=3,
            ).encode()
        )

    def hear(self, timeout: float = WAIT_S) -> dict[str, Any] | Bundle | bytes:
        frame = self.connection.recv(timeout)
        if isinstance(frame, str):
            self.told.append(json.loads(frame))
            return self.told[-1]
        if frame[0] == m.BUNDLE:
            self.bundles.append(Bundle.decode(frame))
            return self.bundles[-1]
        return frame

    def wait_for(self, kind: str, **fields: object) -> dict[str, Any]:
        """The next control message of that type with these fields."""
        deadline = time.monotonic() + WAIT_S
        while time.monotonic() < deadline:
            message = self.hear()
            if isinstance(message, dict) and message["type"] == kind:
                if all(message[name] == value for name, value in fields.items()):
                    return message
                assert kind != "error", message
        raise AssertionError(f"no {kind} {fields} came; told: {self.told[-3:]}")

    def next_tick(self, seat: int = 0) -> int:
        """Read up to the next bundle and answer it with an input; its tick."""
        deadline = time.monotonic() + WAIT_S
        while time.monotonic() < deadline:
            heard = self.hear()
            if isinstance(heard, Bundle):
                self.push(seat, heading=heard.tick / 5)
                return heard.tick
        raise AssertionError(f"no bundle came; told: {self.told[-3:]}")

    def play(self, ticks: int, seat: int = 0) -> list[int]:
        """Play so many ticks; their numbers."""
        return [self.next_tick(seat) for _ in range(ticks)]

    def play_out(self, seat: int = 0) -> dict[str, Any]:
        """Play until the round is over, acknowledging every bundle (who does not is cut off); its result."""
        while not (results := self.results()):
            self.answer_one(seat)
        return results[0]

    def answer_one(self, seat: int = 0) -> None:
        """Hear one thing; a bundle is answered with an input."""
        if isinstance(self.hear(), Bundle):
            self.push(seat)

    def results(self) -> list[dict[str, Any]]:
        return [told for told in self.told if told["type"] == "result"]

    def end(self) -> tuple[int, list[dict[str, Any]]]:
        """Read until the connection is closed: the close code (1006 without one) and what was still told."""
        before = len(self.told)
        try:
            while True:
                self.hear()
        except ConnectionClosed as closed:
            code = closed.rcvd.code if closed.rcvd else 1006
            return code, self.told[before:]


_UNHURRIED = Limits(
    tick_share=9.0, late_share=9.0, requests_per_address_per_s=100_000, accepts_per_address_per_s=100_000
)


@contextmanager
def serve(
    data: Path,
    limits: Limits | None = None,
    app_of: Callable[[Settings], FastAPI] = create_app,
    port: int = 0,
    certificate: Certificate | None = None,
    server_of: Callable[..., GameServer] = game_server,
    **settings: Any,
) -> Iterator[Live]:
    """A server for one `with` block."""
    listening = listen(settings.get("host", "127.0.0.1"), port)
    port = listening.getsockname()[1]
    settings = {"countdown_s": 0.3, **settings}
    chosen = Settings(port=port, data=data, admin_token=ADMIN, limits=limits or _UNHURRIED, **settings)
    started = threading.Event()
    app = app_of(chosen)
    server = server_of(app, chosen, certificate, on_ready=started.set)
    loops: list[asyncio.AbstractEventLoop] = []

    async def serve_until_told() -> None:
        loops.append(asyncio.get_running_loop())
        await server.serve(sockets=[listening])

    thread = threading.Thread(target=lambda: asyncio.run(serve_until_told()), daemon=True)
    thread.start()
    if not started.wait(60):
        raise AssertionError("the server did not start")
    live = Live(port, app.state.host, loops[0], server=server)
    try:
        yield live
    finally:
        server.should_exit = True
        thread.join(60)
        live.hang_up()
        assert not thread.is_alive(), "the server did not stop"


def limits(**changed: Any) -> Limits:
    """The limits of a test: the machine may be busy."""
    return replace(_UNHURRIED, **changed)


def wait_until(holds: Callable[[], bool]) -> None:
    deadline = time.monotonic() + WAIT_S
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def handshake(path: str = "/ws", protocol: str = m.SUBPROTOCOL) -> bytes:
    """The request for a websocket; names of headers are in small letters, as processes hand them over."""
    return (
        f"GET {path} HTTP/1.1\r\nhost: localhost\r\nupgrade: websocket\r\nconnection: Upgrade\r\n"
        f"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        f"sec-websocket-protocol: {protocol}\r\n\r\n"
    ).encode()


def raw_socket(live: Live) -> socket.socket:
    return socket.create_connection(("127.0.0.1", live.port), timeout=WAIT_S)


def _content(answer: Any) -> Any:
    raw = answer.read()
    if "json" in answer.headers.get("content-type", ""):
        return json.loads(raw)
    return raw
