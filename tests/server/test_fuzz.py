"""Whatever a stranger sends, over a websocket or HTTP: a refusal in words, never a fault, and the room plays on.

100 cases each by default; 100,000 each, with 12 minutes of CPU for the longer one (docs/performance.md), by:

    pytest -n 2 --dist load --reruns 0 --hypothesis-profile=long tests/server/test_fuzz.py
"""

import asyncio
import json
import socket
from collections.abc import Callable
from typing import Any, cast

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from movingout.maps import load_map, map_to_json
from movingout.server import messages as m
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import WIRE, Message
from movingout.server.connection.endpoint import SocketEndpoint
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.settings import Settings
from tests.server.live import Live, limits
from tests.server.support import Table, make_input

UNHURRIED = settings(deadline=None, suppress_health_check=list(HealthCheck))
LETTERS = st.text(max_size=8)
WORDS = st.sampled_from(
    ["join", "ready", "again", "pause", "ping", "leave", "skip", "keyframe", "focus", "play", "watch", "room", "en"]
)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | LETTERS | WORDS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(LETTERS, inner, max_size=3),
    max_leaves=6,
)
CONTROLS = st.fixed_dictionaries(
    {"type": WORDS},
    optional={
        "room": st.just("room") | VALUES,
        "mode": WORDS | VALUES,
        "tokens": st.lists(LETTERS, max_size=2) | VALUES,
        "claim": st.integers(-1, 3) | VALUES,
        "seat": st.integers(-1, 2) | VALUES,
        "ready": st.booleans() | VALUES,
        "visible": st.booleans() | VALUES,
        "item": st.integers(-2, 9) | VALUES,
        "name": LETTERS,
    },
)
JOIN = json.dumps({"type": "join", "room": "room", "claim": 1})
INPUT = make_input(seat=0, seq=1).encode()
INPUTS = st.binary(min_size=0, max_size=len(INPUT)).map(lambda raw: INPUT[: len(INPUT) - len(raw)] + raw)
FRAMES = CONTROLS.map(json.dumps) | VALUES.map(json.dumps) | st.text(max_size=40) | st.binary(max_size=60) | INPUTS


class _Wire:
    """A connection that takes everything."""

    def count_until_gone(self, uncount: Callable[[], None]) -> None:
        self.gone = uncount

    def listen(self, on_binary: object, on_writable: object) -> None: ...

    def stop_listening(self) -> None: ...

    def abort(self) -> None: ...

    def write(self, message: str | bytes) -> bool:
        return True


RUNNER = asyncio.Runner()  # a loop for all cases: making one costs as much as a case


async def _said(table: Table, frames: list[str | bytes]) -> list[Message]:
    """What the endpoint answers to a client that sends these frames and hangs up."""
    waiting: list[Message] = [{"type": "websocket.connect"}]
    waiting += [{"type": "websocket.receive", ("text" if isinstance(one, str) else "bytes"): one} for one in frames]
    told: list[Message] = []

    async def receive() -> Message:
        return waiting.pop(0) if waiting else {"type": "websocket.disconnect"}

    async def send(message: Message) -> None:
        told.append(message)

    registry = cast(RoomRegistry, type("Registry", (), {"rooms": {"room": table.room}}))
    admission = AdmissionControl(limits(), lambda: table.now)
    endpoint = SocketEndpoint(Settings(limits=limits()), registry, admission)
    scope = {"headers": [(b"host", b"localhost:8000")], "scheme": "ws", "subprotocols": [m.SUBPROTOCOL]}
    wire = _Wire()
    await endpoint(scope | {"extensions": {WIRE: wire}}, receive, send)
    wire.gone()
    assert (admission.sockets, endpoint.open) == (0, set())
    return told


@UNHURRIED
@given(frames=st.lists(FRAMES, max_size=6), joins=st.booleans())
def test_no_frames_break_a_room_or_the_other_player(frames: list[str | bytes], joins: bool) -> None:
    table = Table("HandOff")
    other = table.join(claim=1)
    table.say(other, m.Ready(0))
    told = RUNNER.run(_said(table, [JOIN, *frames] if joins else frames))
    closes = [one["code"] for one in told if one["type"] == "websocket.close"]
    assert all(4000 <= code < 5000 and code != m.CLOSE_RETRY_LATER for code in closes), "no fault of ours"
    table.seconds(1.0)
    assert table.seats[0].client is other and table.phase != "closed"
    again = table.join(mode="watch")
    assert again in table.room.seating.clients


SEATS = st.fixed_dictionaries(
    {"kind": st.sampled_from(["here", "link", "agent", "remote", "ghost"]) | VALUES},
    optional={
        "agent": st.sampled_from(["idle", "scripted", "os:system", "bass@all", "x@y"]) | VALUES,
        "recording": VALUES,
    },
)
ROOMS = st.fixed_dictionaries(
    {},
    optional={
        "maps": st.lists(st.sampled_from(["Simple", "nowhere", "../x"]) | VALUES, max_size=3) | VALUES,
        "seats": st.lists(SEATS, max_size=3) | VALUES,
        "limit_ticks": st.integers(-5, 10**6) | VALUES,
        "practice": st.booleans() | VALUES,
        "challenge2_seed": st.integers(-3, 2**40) | VALUES,
        "map": VALUES,
        "tutorial": st.booleans() | VALUES,
    },
)
PART = st.text(max_size=12) | st.sampled_from(
    ["..", "%00", "rooms", "aaaaaaaaaaaa", "qr.svg", "answers", "poses", "file"]
)
REAL = (
    "/api/rooms", "/api/maps", "/api/editor/check", "/api/editor/solve", "/api/recordings", "/api/agents",
    "/api/admin/state", "/healthz", "/api/questionnaire", "/metrics", "/", "/static/play/play.js",
)  # fmt: skip
PATHS = st.sampled_from(REAL) | st.lists(PART, min_size=1, max_size=4).map(lambda parts: "/api/" + "/".join(parts))
DRAWN = map_to_json(load_map("Simple"))
SPOILED = st.dictionaries(st.sampled_from([*DRAWN]), VALUES, max_size=2).map(lambda part: {**DRAWN, **part})
MAPS = st.fixed_dictionaries({"map": VALUES | SPOILED})
BODIES = (ROOMS | MAPS | VALUES).map(lambda body: json.dumps(body).encode())


@pytest.mark.slow
@UNHURRIED
@given(
    method=st.sampled_from(["GET", "POST", "PUT", "DELETE", "HEAD", "OPTIONS"]),
    path=PATHS,
    body=BODIES | st.binary(max_size=80),
    token=st.sampled_from(["", "Bearer x", "Basic eDp5", "Bearer "]),
    kind=st.sampled_from(["application/json", "text/plain", ""]),
)
def test_no_request_is_a_fault(http: httpx.Client, method: str, path: str, body: bytes, token: str, kind: str) -> None:
    headers = {"authorization": token, "content-type": kind}
    try:
        answer = http.request(method, path, content=body, headers=headers)
    except (httpx.InvalidURL, httpx.LocalProtocolError, UnicodeError):
        return  # a client cannot send it
    assert answer.status_code in {*range(200, 430), 503}, (answer.status_code, answer.text)
    if answer.status_code >= 400 and answer.request.url.path.startswith("/api/") and method != "HEAD":
        error: dict[str, Any] = answer.json()["error"]
        assert error["code"] and error["message"]


@pytest.mark.parametrize("path", REAL)
def test_what_is_drawn_is_there(http: httpx.Client, path: str) -> None:
    found = {http.request(method, path).status_code for method in ("GET", "POST")}
    assert found != {404}, "a path that is nowhere proves nothing"


@pytest.fixture(scope="module")
def http(shared_server: Live) -> Any:
    at_once = [(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)]  # or a body waits 40 ms for the ACK of its head
    transport = httpx.HTTPTransport(socket_options=at_once)
    with httpx.Client(base_url=f"http://{shared_server.address}", timeout=30.0, transport=transport) as client:
        yield client
