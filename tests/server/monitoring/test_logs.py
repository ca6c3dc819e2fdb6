"""The log: not flooded, no control characters, no addresses, and one JSON object per line where that is wanted."""

import io
import json
import logging
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed

from movingout.server.monitoring.logs import PER_MINUTE, JsonFormatter, LogFormat, RateLimit, log_to, printable
from tests.server.live import WAIT_S, raw_socket, serve


def test_a_flood_of_one_message_leaves_few_lines_and_says_how_many_were_left_out() -> None:
    stream, now = io.StringIO(), [0.0]
    log_to(stream)
    handler = logging.getLogger().handlers[0]
    handler.filters[:] = [RateLimit(lambda: now[0])]
    for count in range(1723):
        logging.getLogger("flood").warning("a bad origin: %s", count)
    logging.getLogger("other").warning("still heard")
    lines = stream.getvalue().splitlines()
    assert len(lines) == 2 * PER_MINUTE + 1 and lines[-1].endswith("still heard")
    now[0] += 60.0
    logging.getLogger("flood").warning("a bad origin: %s", "again")
    assert "(1703 more like this were left out)" in stream.getvalue().splitlines()[-1]


@pytest.mark.parametrize("count", range(2))
def test_a_log_ends_with_its_test(count: int, capsys: pytest.CaptureFixture[str]) -> None:
    logging.getLogger("a server of the session").warning("somebody is away")
    assert capsys.readouterr().err == "", "a line of another test's"
    log_to()


def test_nobody_writes_lines_or_colours_into_the_log() -> None:
    stream = io.StringIO()
    log_to(stream)
    logging.getLogger("x").warning("name: %s", "Eve\nERROR server: all is lost\x1b[2J\u202e")
    assert stream.getvalue().count("\n") == 1 and "\x1b" not in stream.getvalue()


@pytest.mark.parametrize(
    "address",
    [
        "192.168.17.4",
        "2001:db8:0:1:2:3:4:5",
        "2001:db8:0:1::5",
        "2001:db8::1",
        "2a02::5",
        "fe80::1ff:fe23:4567:890a",
        "::ffff:192.0.2.7",
    ],
)
def test_addresses_of_people_stay_out_of_the_log(address: str) -> None:
    for sentence in ("a client at {} left", "from {}.", "{}: refused", "client:{}, gone", "('{}', 443)", "[{}]:443"):
        assert printable(sentence.format(address)) == sentence.format("[address]")


@pytest.mark.parametrize(
    "run",
    [
        "2003:c1:ef2a:5b00:1c3f:a7:b1:c2:51234",
        "2003:c1:ef2a:5b00:1c3f:a7:b1:c2:443",
        "2001:db8::7:51234",
        "abc:2001:db8:0:0:0:0:0:1",
        "facade:2001:db8::1:51234",
    ],
)
def test_of_an_address_with_a_port_or_behind_a_word_nothing_stays(run: str) -> None:
    for sentence in ("a client at {} left", "from {}.", "{}: refused"):
        assert printable(sentence.format(run)) == sentence.format("[address]")


@pytest.mark.parametrize(
    "text",
    [
        "listening at 127.0.0.1:8000, version 1.2.3, 12:30:05",
        "listening at ::1, [::1]:8000, ::1:51234, :: and ::ffff:127.0.0.1",
        "12:34:56:78 of std::abc, bass@any::dead",
    ],
)
def test_what_is_no_address_of_anybody_stays_in_the_log(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_traceback_says_no_address_and_obeys_no_stranger(form: LogFormat) -> None:
    stream = io.StringIO()
    log_to(stream, form)
    try:
        raise ValueError("the peer 2001:db8::7 said \x1b[2J")
    except ValueError:
        logging.getLogger("x").exception("it failed")
    told = stream.getvalue()
    assert "the peer [address] said" in told and "db8" not in told.split("ValueError")[-1]
    assert "\x1b" not in told and "\\u001b" not in told
    assert '  File "' in json.loads(told)["exception"] if form == "json" else '\n  File "' in told, "indented as ever"


def test_json_has_one_object_per_line_with_the_traceback() -> None:
    try:
        raise ValueError("broken")
    except ValueError as error:
        exc_info = (type(error), error, error.__traceback__)
    record = logging.LogRecord("a.b", logging.ERROR, "x.py", 1, "it %s", ("failed",), exc_info)
    line = JsonFormatter().format(record)
    row = json.loads(line)
    assert "\n" not in line and row["level"] == "error" and row["message"] == "it failed"
    assert "ValueError: broken" in row["exception"] and row["at"].endswith("+00:00")


def test_what_uvicorn_says_of_strangers_is_json_too_and_no_flood(tmp_path: Path) -> None:
    """It set up a log of its own when the server was made: a line for each bad request, of no form and no limit."""
    stream = io.StringIO()
    log_to(stream, "json")
    with serve(tmp_path) as live:
        for _ in range(5 * PER_MINUTE):
            with raw_socket(live) as client:
                client.sendall(b"FOO / HTTP/1.1\r\n\r\n")
                assert client.recv(100).startswith(b"HTTP/1.1 400")
        with live.connect(live.open_room("here", "idle")["room"]) as connection:
            connection.send(b"\xff\xfe", text=True)
            with pytest.raises(ConnectionClosed) as closed:
                connection.recv(timeout=WAIT_S)
    assert closed.value.rcvd is not None and closed.value.rcvd.code == 1007
    rows = [json.loads(line) for line in stream.getvalue().splitlines()]
    assert [row["message"] for row in rows] == ["Invalid HTTP request received."] * 2 * PER_MINUTE


def test_errors_that_asyncio_reports_of_one_place_are_of_one_kind() -> None:
    """Their text names objects by their addresses: each was a kind of its own, without a limit."""
    stream = io.StringIO()
    log_to(stream)
    for count in range(100):
        place = f"<object at 0x{count:x}>"
        logging.getLogger("asyncio").error(f"Fatal error on transport\ntransport: {place}")
        logging.getLogger("asyncio").error(f"Exception in callback {place}\nhandle: {place}")
        logging.getLogger("asyncio").error(f"Exception in callback Room.tick({place})\nhandle: {place}")
    text = stream.getvalue()
    for kind in ("Fatal error on transport", "Exception in callback <", "Exception in callback Room.tick("):
        assert text.count(kind) == 2 * PER_MINUTE
