"""The threat table, what is sent: sizes, floods, broken frames, slow readers. Numbers are its rows."""

import contextlib
import json
import random
import socket
import struct
import time
from pathlib import Path

import msgspec
import psutil
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed, InvalidStatus

from movingout.server import messages as m
from movingout.server.frame_layout import FrameError
from movingout.server.frames import Bundle, decode_client_frame
from movingout.server.rooms.seat_assignment import SeatAssignment
from tests.server.live import WAIT_S, Live, limits, raw_socket, serve
from tests.server.support import make_input
from tests.server.threats import close_code, player

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


@pytest.mark.parametrize(
    "wrong",
    [
        b"POST /ws HTTP/1.1\r\n",
        b"GET /ws HTTP/1.1\r\nContent-Length: 4\r\n",
        b"GET /ws HTTP/1.1\r\nTransfer-Encoding: chunked\r\n",
        b"GET /ws HTTP/1.1\r\nX: " + b"a" * 9000 + b"\r\n",
        b"GET /ws HTTP/1.1\r\n" + b"X: a\r\n" * 200,
    ],
    ids=["post", "body", "chunks", "long line", "many lines"],
)
def test_4_a_handshake_that_can_never_be_one_is_answered_and_closed(live: Live, wrong: bytes) -> None:
    """It was held for ever outside of every limit, with all that came after it: 600 of one address, 30 MB of one."""
    head = b"Host: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    with raw_socket(live) as client:
        client.sendall(wrong + head + b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n")
        answer = b"".join(iter(lambda: client.recv(10_000), b""))
    assert answer.startswith(b"HTTP/1.1 400"), answer
    assert b"not the handshake of a websocket" in answer


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


@pytest.mark.parametrize("path", ["/api/editor/check", "/api/editor/solve", "/api/rooms"])
def test_4_a_nested_map_is_refused_as_any_other(live: Live, path: str) -> None:
    beside = {"maps": [], "seats": [{"kind": "here"}, {"kind": "link"}]} if path == "/api/rooms" else {}
    for depth in (100, 400, 600, 800):  # the last ones can be read, but not sent to the process that checks maps
        status, answer = live.call(path, {"map": json.loads('{"a":' * depth + "1" + "}" * depth), **beside})
        assert status == 422 or (status, answer["map"]) == (200, None)


def test_4_a_join_full_of_keys_is_refused_before_any_of_them_is_compared(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared: list[str] = []
    monkeypatch.setattr(SeatAssignment, "was_token", lambda _, token: compared.append(token))
    room = live.open_room("here", "idle")["room"]
    for keys, code in ((m.MOST_TOKENS, m.CLOSE_UNAUTHORISED), (1300, m.CLOSE_BAD_MESSAGE)):
        connection = live.connect(room)
        connection.send(json.dumps({"type": "join", "room": room, "tokens": [""] * keys}, separators=(",", ":")))
        assert close_code(connection) == code
    assert len(compared) == m.MOST_TOKENS


# ---- 5 flood --------------------------------------------------------------------------------------------------


def test_5_a_flood_is_cut_off_without_a_close_frame(live: Live) -> None:
    person = player(live)
    frame = make_input(move=1.0).encode()
    started = time.monotonic()
    with pytest.raises((ConnectionClosed, OSError)):
        for _ in range(100_000):
            person.connection.send(frame)
    assert time.monotonic() - started < 10
    assert person.connection.close_code == 1006
    assert live.call("/healthz")[0] == 200


def test_5_who_has_no_seat_may_say_less(tmp_path: Path) -> None:
    with serve(tmp_path, limits(watcher_messages_per_s=0.01, message_burst=5)) as live:
        room = live.open_room("here", "idle")
        blue, watcher = live.person(room["room"], tokens=room["tokens"][:1]), live.person(room["room"], mode="watch")
        for person in (blue, watcher):
            for _ in range(12):
                person.say(type="focus", visible=True)
        with pytest.raises(ConnectionClosed):
            for _ in range(15):
                watcher.connection.recv(WAIT_S)
        blue.say(type="ready", seat=0, ready=True)
        assert blue.wait_for("room", phase="countdown")


def test_5_a_flood_that_goes_on_after_a_close_is_cut_off_too(live: Live) -> None:
    connection = live.connect()
    connection.send(json.dumps({"type": "join", "room": "nowhere"}))
    flood = (bytes((0x82, 0x80 | 28)) + bytes(4) + make_input(move=1.0).encode()) * 500
    started = time.monotonic()
    with pytest.raises(OSError):
        for _ in range(10_000):
            connection.socket.sendall(flood)
    assert time.monotonic() - started < 8


EMPTY_PONG, UNFINISHED_TEXT, EMPTY_CONTINUATION = (bytes((first, 0x80)) + bytes(4) for first in (0x8A, 0x01, 0x00))


@pytest.mark.parametrize(
    ("first", "flood"), [(b"", EMPTY_PONG), (UNFINISHED_TEXT, EMPTY_CONTINUATION)], ids=["pongs", "continuations"]
)
def test_5_frames_that_are_no_messages_are_counted_too(live: Live, first: bytes, flood: bytes) -> None:
    person = player(live)
    with pytest.raises(OSError):
        person.connection.socket.sendall(first)
        for _ in range(20_000):
            person.connection.socket.sendall(flood * 100)
    assert person.end()[0] == 1006
    assert live.call("/healthz")[0] == 200


def test_5_a_message_in_a_few_fragments_is_read(live: Live) -> None:
    connection = live.connect()
    connection.send(iter(['{"type":"join",', '"room":', '"nowhere"}']))
    assert close_code(connection) == m.CLOSE_NOT_FOUND


def test_5_whoever_floods_again_and_again_has_to_wait_and_fills_no_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")["room"]
        flood = (bytes((0x82, 0x80 | 28)) + bytes(4) + make_input(move=1.0).encode()) * 200
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
        make_input(seq=2**32 - 1, move=1.0, client_ms=float("nan")).encode(),
        make_input(seat=5, move=1.0).encode(),
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
    person.connection.send(
        make_input(
            seq=2**32 - 1,
            ack_tick=2**32 - 1,
            seen_tick=2**32 - 1,
            move=1.0,
            heading=3.14,
            grabs=255,
            device=3,
            client_ms=1e308,
        ).encode()
    )
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


@pytest.mark.slow
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
