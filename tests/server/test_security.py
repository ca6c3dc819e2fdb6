"""Each row of the threat table: what a hostile page, client or request gets. Numbers are those of the table."""

import contextlib
import http.client
import json
import logging
import random
import re
import socket
import struct
import time
import urllib.request
from pathlib import Path

import msgspec
import psutil
import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from server import http_api
from server import messages as m
from server.frames import Bundle, FrameError, Input, decode_client_frame
from server.headers import content_security_policy
from server.host import Host
from server.pages import WEB
from server.settings import Limits, Settings
from tests.server.live import ADMIN, Live, Person, limits, raw_socket, serve


def close_code(connection: ClientConnection, seconds: float = 10.0) -> int:
    """Read until the end: the close code, 1006 for none."""
    deadline = time.monotonic() + seconds
    try:
        while time.monotonic() < deadline:
            connection.recv(max(0.01, deadline - time.monotonic()))
    except ConnectionClosed as closed:
        return closed.rcvd.code if closed.rcvd else 1006
    except TimeoutError:
        pass
    raise AssertionError("the connection stays open")


def player(live: Live) -> Person:
    room = live.open_room("here", "idle")
    return live.person(room["room"], tokens=[room["tokens"][0]])


# ---- 1 Origin -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1", "http://localhost:{port}"],
)
def test_1_a_foreign_page_gets_no_socket_and_no_room(live: Live, origin: str, caplog: pytest.LogCaptureFixture) -> None:
    origin = origin.format(port=live.port)
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://{live.address}/ws", subprotocols=[m.SUBPROTOCOL], origin=origin)  # type: ignore[list-item, arg-type]
    assert refused.value.response.status_code == 403
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": []}, Origin=origin)
    assert (status, answer["error"]["code"]) == (403, "origin")


def test_1_the_servers_own_page_and_programs_without_origin_are_let_in(live: Live) -> None:
    own = f"http://{live.address}"
    connect(f"ws://{live.address}/ws", subprotocols=[m.SUBPROTOCOL], origin=own).close()  # type: ignore[list-item, arg-type]
    live.connect()


# ---- 2 seats --------------------------------------------------------------------------------------------------


def test_2_a_token_of_another_room_a_cut_one_and_an_old_one_are_refused(live: Live) -> None:
    first, second = live.open_room("here", "idle"), live.open_room("here", "idle")
    token, other = first["tokens"][0], second["tokens"][0]
    for wrong in (other, token[:-1], token + "x", "", "x" * 22):
        connection = live.connect()
        connection.send(json.dumps({"type": "join", "room": first["room"], "tokens": [wrong]}))
        assert close_code(connection) == m.CLOSE_UNAUTHORISED
    person = live.person(first["room"], tokens=[token])
    person.say(type="keyframe")
    person.wait_for("keyframe")
    connection = live.connect()
    connection.send(json.dumps({"type": "join", "room": first["room"], "tokens": [token]}))
    assert close_code(connection) == m.CLOSE_UNAUTHORISED


def test_2_guessing_is_locked_out_after_ten_tries(tmp_path: Path) -> None:
    with serve(tmp_path, limits(wrong_tokens_per_minute=10)) as live:
        room = live.open_room("here", "idle")
        for _ in range(11):
            connection = live.connect()
            connection.send(json.dumps({"type": "join", "room": room["room"], "tokens": ["guess"]}))
            assert close_code(connection) == m.CLOSE_UNAUTHORISED
        connection = live.connect()
        connection.send(json.dumps({"type": "join", "room": room["room"], "tokens": room["tokens"][:1]}))
        assert "wait a minute" in json.loads(connection.recv(10))["message"]
        for _ in range(11):
            assert live.call("/api/admin/state", token=ADMIN)[0] == 200, "guessing seats locks no administrator out"
        for _ in range(11):
            assert live.call("/api/admin/state", token="guess")[0] == 403
        status, answer = live.call("/api/admin/state", token=ADMIN)
        assert (status, answer["error"]["code"]) == (429, "locked")


def test_2_tokens_are_kept_as_hashes_only(live: Live) -> None:
    person = player(live)
    live.run(live.host.store.flush)
    kept = "".join(path.read_text() for path in live.host.settings.rooms.glob("*.json"))
    assert kept and person.tokens[0] not in kept


# ---- 3 administration -----------------------------------------------------------------------------------------


def test_3_every_admin_route_wants_the_admin_token(live: Live) -> None:
    token = player(live).tokens[0]
    app_routes = [route for route in _routes(live) if isinstance(route, APIRoute)]
    admin = [route for route in app_routes if route.path.startswith("/api/admin") or route.path == "/api/recordings"]
    assert len(admin) >= 4
    for route in admin:
        for method in route.methods or ():
            path = route.path.replace("{room_id}", "x")
            assert live.call(path, method=method)[0] == 401
            assert live.call(path, method=method, token=token)[0] == 403
    assert live.call("/api/admin/state", token=ADMIN)[0] == 200


def _routes(live: Live) -> list[object]:
    """All routes of a fresh application, included ones flattened."""
    app = FastAPI()
    http_api.install(app, live.host)
    found: list[object] = []
    waiting = list(app.router.routes)
    while waiting:
        route = waiting.pop()
        found.append(route)
        inner = getattr(route, "original_router", None) or getattr(route, "router", None)
        waiting.extend(getattr(inner, "routes", []))
    return found


def test_3_a_server_that_is_given_no_admin_token_makes_one_and_loopback_is_the_default() -> None:
    assert Settings().host == "127.0.0.1"
    first, second = Host(Settings()), Host(Settings())
    assert first.admin_token != second.admin_token and len(first.admin_token) >= 20


# ---- 4 sizes --------------------------------------------------------------------------------------------------


def test_4_a_frame_of_4096_bytes_is_read_and_one_of_4097_is_not(live: Live) -> None:
    for size, code in ((4096, m.CLOSE_BAD_MESSAGE), (4097, 1009)):
        connection = live.connect()
        connection.send("x" * size)
        assert close_code(connection) == code


def test_4_a_frame_that_announces_a_terabyte_is_refused_at_its_head(live: Live) -> None:
    person = player(live)
    head = struct.pack(">BBQ", 0x82, 0x80 | 127, 1 << 40) + b"\0\0\0\0"
    person.connection.socket.sendall(head)
    assert close_code(person.connection) == 1009


def test_4_many_fragments_do_not_add_up(live: Live) -> None:
    person = player(live)
    with contextlib.suppress(OSError):
        for count in range(10):
            head = struct.pack(">BBH", 0x00 if count else 0x01, 0x80 | 126, 1000) + bytes(4)
            person.connection.socket.sendall(head + b"x" * 1000)
    assert person.end()[0] in (1009, 1006), "a reset for what is still under way may overtake the close frame"


def test_4_a_body_beyond_the_limit_is_refused_announced_or_not(live: Live) -> None:
    assert live.call("/api/rooms", {"x": "y" * 20_000})[0] == 413
    with raw_socket(live) as client:
        client.sendall(b"POST /api/rooms HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n")
        for _ in range(5):
            client.sendall(b"1000\r\n" + b"z" * 4096 + b"\r\n")
        assert client.recv(100).startswith(b"HTTP/1.1 413")


def test_4_nested_json_is_no_stack_overflow(live: Live) -> None:
    for text in ("[" * 4000, '{"type":' * 400, '{"type":"join","room":' + "[" * 3000 + "}"):
        connection = live.connect()
        connection.send(text)
        assert close_code(connection) == m.CLOSE_BAD_MESSAGE
    status, _ = live.call("/api/rooms", json.loads("[" * 500 + "]" * 500))
    assert status == 422


# ---- 5 flood --------------------------------------------------------------------------------------------------


def test_5_a_flood_is_cut_off_without_a_close_frame(live: Live) -> None:
    person = player(live)
    frame = Input(0, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode()
    started = time.monotonic()
    with pytest.raises((ConnectionClosed, OSError)):
        for _ in range(100_000):
            person.connection.send(frame)
    assert time.monotonic() - started < 10
    assert person.connection.close_code == 1006
    assert live.call("/healthz")[0] == 200


def test_5_a_flood_that_goes_on_after_a_close_is_cut_off_too(live: Live) -> None:
    connection = live.connect()
    connection.send(json.dumps({"type": "join", "room": "nowhere"}))
    flood = (bytes((0x82, 0x80 | 28)) + bytes(4) + Input(0, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode()) * 500
    started = time.monotonic()
    with pytest.raises(OSError):
        for _ in range(10_000):
            connection.socket.sendall(flood)
    assert time.monotonic() - started < 8


def test_5_whoever_floods_again_and_again_has_to_wait_and_fills_no_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")["room"]
        flood = (bytes((0x82, 0x80 | 28)) + bytes(4) + Input(0, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode()) * 200
        with pytest.raises(InvalidStatus) as refused:
            for _ in range(30):
                person = live.person(room, mode="watch")
                with contextlib.suppress(OSError):
                    person.connection.socket.sendall(flood)
                assert person.end()[0] == 1006
        assert b"flooded" in refused.value.response.body
        assert live.call("/healthz")[0] == 200
    assert len([record for record in caplog.records if "cut off" in record.getMessage()]) == 1


def test_5_two_people_at_one_screen_stay_within_the_rate(live: Live) -> None:
    room = live.open_room("here", "here")
    both = live.person(room["room"], tokens=room["tokens"])
    for _ in range(100):  # a burst of 1.6 s of inputs of two seats, acknowledgements with them
        both.push(0)
    both.say(type="keyframe")
    assert both.wait_for("keyframe")


# ---- 6, 7 malformed -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "frame",
    [
        b"\x03",
        b"\xff" * 28,
        bytes(28),
        Input(0, 2**32 - 1, 0, 0, 1.0, 0.0, 0, 0, float("nan")).encode(),
        Input(5, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode(),
        b"\x01" + bytes(60),
        '{"type":"ready","seat":"0"}',
        '{"type":"ready","seat":0,"admin":true}',
        '{"type":"shutdown"}',
        '{"seat":0}',
        "\x00",
        "[]",
    ],
)
def test_6_a_malformed_message_closes_with_4400_and_a_sentence(live: Live, frame: bytes | str) -> None:
    person = player(live)
    person.connection.send(frame)
    code, told = person.end()
    assert (code, told[-1]["type"]) == (m.CLOSE_BAD_MESSAGE, "bye")
    assert told[-1]["message"]


def test_6_huge_numbers_are_only_numbers(live: Live) -> None:
    person = player(live)
    person.connection.send(Input(0, 2**32 - 1, 2**32 - 1, 2**32 - 1, 1.0, 3.14, 255, 3, 1e308).encode())
    person.say(type="ready", seat=0)
    person.wait_for("room", phase="playing")
    person.say(type="ready", seat=2**62)
    assert person.wait_for("error")["code"] == "not_your_seat"


@pytest.mark.parametrize(
    "raw",
    [
        b"\x82\x05hello",  # unmasked
        b"\x83\x80\0\0\0\0",  # opcode 3
        b"\xc2\x80\0\0\0\0",  # RSV1
        b"\x81\x82\0\0\0\0\xff\xfe",  # bad UTF-8
        b"\x89\xfe\x00\x80\0\0\0\0" + bytes(128),  # a control frame that is too long
    ],
    ids=["unmasked", "opcode", "reserved", "utf8", "long ping"],
)
def test_6_broken_frames_are_protocol_errors(live: Live, raw: bytes) -> None:
    person = player(live)
    person.connection.socket.sendall(raw)
    assert close_code(person.connection) in (1002, 1007)


frames = st.one_of(
    st.binary(max_size=80),
    st.builds(lambda kind, rest: bytes([kind]) + rest, st.sampled_from([3, 4]), st.binary(min_size=8, max_size=27)),
    st.text(max_size=80),
    st.sampled_from(["join", "ready", "pause", "leave", "again", "keyframe", "focus"]).map(
        lambda kind: json.dumps({"type": kind, "seat": 0})
    ),
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(sent=st.lists(frames, max_size=8))
def test_6_whatever_is_sent_the_server_answers_and_logs_no_traceback(
    live: Live, caplog: pytest.LogCaptureFixture, sent: list[bytes | str]
) -> None:
    person = player(live)
    try:
        for frame in sent:
            person.connection.send(frame)
        person.connection.close()
    except ConnectionClosed:
        pass
    assert live.call("/healthz")[0] == 200
    assert not [record for record in caplog.records if record.exc_info]


@pytest.mark.slow
def test_6_a_hundred_thousand_random_frames_through_the_decoders() -> None:
    random.seed(4)
    decode = msgspec.json.Decoder(m.ClientMessage).decode
    refused = 0
    for _ in range(100_000):
        raw = bytes([random.choice((3, 4, 5, 123))]) + random.randbytes(random.choice((8, 27, 0, 40)))
        try:
            decode_client_frame(raw)
        except FrameError:
            refused += 1
        try:
            decode(raw)
        except (msgspec.MsgspecError, UnicodeError):
            refused += 1
    assert refused > 100_000


# ---- 8 slow readers -------------------------------------------------------------------------------------------


def test_8_a_client_that_never_reads_is_closed_and_costs_no_memory(live: Live) -> None:
    room = live.open_room("here", "link")
    blue = live.person(room["room"], tokens=[room["tokens"][0]])
    red = _deaf_player(live, room["room"])
    blue.say(type="ready", seat=0)
    blue.wait_for("room", phase="playing")
    before = psutil.Process().memory_info().rss
    while blue.told[-1].get("phase") != "paused":
        if isinstance(blue.hear(), Bundle):
            blue.push()
        assert len(blue.bundles) < 100, "still playing after ten seconds"
    assert psutil.Process().memory_info().rss - before < 20e6
    red.close()


def _deaf_player(live: Live, room: str) -> socket.socket:
    """Joins, is ready, then never reads again."""
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect(("127.0.0.1", live.port))
    client.sendall(
        f"GET /ws HTTP/1.1\r\nHost: {live.address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {'A' * 22}==\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: {m.SUBPROTOCOL}\r\n\r\n".encode()
    )
    assert b" 101 " in client.recv(1000)
    for message in (m.Join(room, claim=1), m.Ready(1)):
        payload = msgspec.json.encode(message)
        client.sendall(bytes((0x81, 0x80 | len(payload))) + b"\0\0\0\0" + payload)
        time.sleep(0.2)
    return client


# ---- 9, 10 slow and many --------------------------------------------------------------------------------------


def test_9_a_request_that_trickles_is_dropped_and_others_are_served(tmp_path: Path) -> None:
    with serve(tmp_path, limits(header_s=1.0, join_s=1.0)) as live:
        tricklers = [raw_socket(live) for _ in range(100)]
        for client in tricklers[:50]:
            client.sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ")
        started = time.monotonic()
        player(live)
        assert time.monotonic() - started < 5
        for client in tricklers:
            client.settimeout(10)
            assert _ends(client)
            client.close()


def test_9_a_body_that_trickles_is_dropped(tmp_path: Path) -> None:
    with serve(tmp_path, limits(header_s=1.0)) as live, raw_socket(live) as client:
        client.sendall(b"POST /api/rooms HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n{")
        client.settimeout(10)
        assert _ends(client)


def test_9_an_idle_connection_that_was_served_before_does_not_stay_for_ever(tmp_path: Path) -> None:
    with serve(tmp_path, limits(header_s=1.0)) as live, raw_socket(live) as client:
        client.sendall(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n")
        assert client.recv(2000).startswith(b"HTTP/1.1 200")
        client.sendall(b"GET /hea")
        client.settimeout(10)
        assert _ends(client)


def _ends(client: socket.socket) -> bool:
    try:
        while client.recv(1000):
            pass
    except ConnectionError:
        pass
    return True


def test_10_sockets_that_never_join_are_closed_and_limited(tmp_path: Path) -> None:
    with serve(tmp_path, limits(join_s=1.5, waiting_per_address=5)) as live:
        waiting = [live.connect() for _ in range(5)]
        with pytest.raises(InvalidStatus) as refused:
            live.connect()
        assert refused.value.response.status_code == 503
        assert b"have not joined" in refused.value.response.body
        assert [close_code(each) for each in waiting] == [m.CLOSE_BAD_MESSAGE] * 5
        player(live)


def test_10_sockets_are_limited_per_address_and_in_all(tmp_path: Path) -> None:
    with serve(tmp_path, limits(sockets_per_address=2)) as live:
        for _ in range(2):
            player(live)
        with pytest.raises(InvalidStatus, match="503"):
            live.connect()
    with serve(tmp_path, limits(sockets=1)) as live:
        player(live)
        with pytest.raises(InvalidStatus, match="503"):
            live.connect()


def test_10_connections_per_address_are_limited(tmp_path: Path) -> None:
    with serve(tmp_path, limits(connections_per_address=3)) as live:
        held = [raw_socket(live) for _ in range(3)]
        time.sleep(0.1)
        with raw_socket(live) as one_more:
            assert _ends(one_more)
        for client in held:
            client.close()


def test_10_rooms_are_limited_with_a_sentence(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms=2)) as live:
        for _ in range(2):
            live.open_room("here", "idle")
        status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]})
        assert (status, answer["error"]["code"]) == (503, "full")
        assert "All 2 rooms" in answer["error"]["message"]


def test_10_a_busy_processor_opens_no_more_rooms(tmp_path: Path) -> None:
    with serve(tmp_path, limits(cpu_share=0.7)) as live:
        live.host.cpu_share = 0.9
        status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]})
        assert status == 503 and "busy" in answer["error"]["message"]


# ---- 11 pings -------------------------------------------------------------------------------------------------


def test_11_a_flood_of_pings_is_cut_off(live: Live) -> None:
    person = player(live)
    with pytest.raises((ConnectionClosed, OSError)):
        for _ in range(2000):
            person.connection.socket.sendall(b"\x89\x80\0\0\0\0")
            time.sleep(0)
        close_code(person.connection)
        raise ConnectionResetError
    assert live.call("/healthz")[0] == 200


# ---- 12 files -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "..%2f..%2fetc%2fpasswd", "%2e%2e%2f%2e%2e%2fsecret", "%252e%252e%252fsecret", "%2fetc%2fpasswd", "secret%00",
        "..%5csecret", "C:%5csecret", "link", "CON", ".hidden", "x" * 300, "secret.mcap",
    ],
)  # fmt: skip
def test_12_no_name_leads_out_of_the_recordings(live: Live, name: str) -> None:
    folder = live.host.settings.recordings
    (folder.parent / "secret.mcap").write_bytes(b"secret")
    link = folder / "link.mcap"
    if not link.is_symlink():
        link.symlink_to(folder.parent / "secret.mcap")
    for path in (f"/api/recordings/{name}/file", f"/api/recordings/{name}", f"/api/recordings/{name}/poses"):
        status, content = live.call(path)
        assert status == 404 and b"secret" not in json.dumps(content).encode().replace(name.encode(), b"")


@pytest.mark.parametrize(
    "path",
    [
        "/static/../pyproject.toml",
        "/static/%2e%2e/pyproject.toml",
        "/static/__init__.py",
        "/static/jsconfig.json",
        "/static/tests/render.test.js",
        "/static/",
    ],
)
def test_12_only_what_pages_are_made_of_is_served(live: Live, path: str) -> None:
    assert live.call(path)[0] == 404


def test_12_a_recording_is_sent_as_an_attachment(live: Live) -> None:
    room = live.open_room("here", "idle", limit_ticks=10)
    person = live.person(room["room"], tokens=[room["tokens"][0]])
    person.say(type="ready", seat=0)
    recording = person.wait_for("result")["recording"]
    with urllib.request.urlopen(f"http://{live.address}/api/recordings/{recording}/file") as answer:
        assert answer.headers["content-disposition"] == f'attachment; filename="{recording}.mcap"'
        assert answer.headers["x-content-type-options"] == "nosniff"


# ---- 13 pages -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/play/x",
        "/watch/x",
        "/practice",
        "/replay/x",
        "/api/maps",
        "/nothing",
        "/static/messages.js",
        "/api/admin/state",
    ],
)
def test_13_every_answer_carries_the_security_headers(live: Live, path: str) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
    connection.request("GET", path)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    headers = {name.lower(): value for name, value in answer.getheaders()}
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "same-origin"
    policy = headers["content-security-policy"]
    for part in ("default-src 'self'", "object-src 'none'", "base-uri 'none'", "frame-ancestors 'none'"):
        assert part in policy
    assert "unsafe" not in policy
    assert "server" not in headers


def test_13_no_page_holds_inline_script_or_style() -> None:
    for page in WEB.glob("*.html"):
        text = page.read_text()
        assert not re.search(r"<script(?![^>]*\bsrc=)", text), page.name
        assert not re.search(r"<style|\sstyle=|\son[a-z]+=|javascript:", text), page.name


def test_13_a_strange_host_does_not_get_into_the_policy() -> None:
    assert "evil" not in content_security_policy("x; script-src evil")
    assert "ws://[::1]:8000" in content_security_policy("[::1]:8000")


# ---- 14, 15 addresses and logs --------------------------------------------------------------------------------


def test_14_a_spoofed_forwarded_address_is_not_believed(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms_per_address_per_minute=2)) as live:
        body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}
        answers = [live.call("/api/rooms", body, X_Forwarded_For=f"10.0.0.{count}")[0] for count in range(3)]
    assert answers == [200, 200, 429]


def test_14_a_trusted_proxy_is_believed(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms_per_address_per_minute=2), trusted_proxies=("127.0.0.1",)) as live:
        body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}
        answers = [live.call("/api/rooms", body, X_Forwarded_For=f"10.0.0.{count}")[0] for count in range(3)]
    assert answers == [200, 200, 200]


def test_15_no_token_is_logged_and_none_is_in_an_address(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level(logging.DEBUG)
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle", limit_ticks=10)
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        person.say(type="ready", seat=0)
        person.wait_for("result")
        live.call("/api/admin/state", token=ADMIN)
        live.call(f"/api/rooms/{room['room']}/answers", token=person.tokens[0])
        secrets = [ADMIN, room["tokens"][0], *person.tokens]
        assert not any(secret in room["join_path"] + room["watch_path"] for secret in secrets)
    logged = "\n".join(
        record.getMessage() for record in caplog.records if not record.name.startswith("websockets")
    )  # the test's own client logs what it sends
    printed = "".join(capfd.readouterr())
    assert not [secret for secret in secrets if secret in logged + printed]


# ---- 16, 17 models and people ---------------------------------------------------------------------------------


@pytest.mark.parametrize("agent", ["os:system", "subprocess:run", "tests.x:y", "unknown", "", "scripted;x"])
def test_16_nobody_imports_code_through_an_agents_name(live: Live, agent: str) -> None:
    body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": agent}]}
    status, answer = live.call("/api/rooms", body)
    assert (status, answer["error"]["code"]) == (422, "unknown_agent")
    assert "known: scripted" in answer["error"]["message"]


def test_17_recordings_hold_pseudonyms_and_no_nickname(live: Live) -> None:
    room = live.open_room("here", "link", limit_ticks=10)
    blue = live.person(room["room"], tokens=[room["tokens"][0]], name="Ada Lovelace")
    red = live.person(room["room"], claim=1, name="Grace Hopper")
    blue.say(type="ready", seat=0)
    red.say(type="ready", seat=1)
    recording = blue.wait_for("result")["recording"]
    _, summary = live.call(f"/api/recordings/{recording}")
    names = [seat["name"] for seat in summary["seats"]]
    assert all(name.startswith("person-") for name in names)
    _, file = live.call(f"/api/recordings/{recording}/file")
    assert b"Ada" not in json.dumps(summary).encode() + file and b"Hopper" not in file


def test_defaults_are_the_tables_numbers() -> None:
    assert Limits().frame_bytes == 4096
    assert (Limits().join_s, Limits().header_s) == (5.0, 10.0)
    assert (Limits().messages_per_s, Limits().message_burst) == (60.0, 60.0)
