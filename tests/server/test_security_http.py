"""The threat table, floods of requests and connections, downloads that nobody reads, and bytes on the disk."""

import contextlib
import http.client
import socket
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.connection_limits import ConnectionLimits, both_forms, is_trusted
from movingout.server.host import Host
from movingout.server.monitoring.overload import Overload
from movingout.server.persistence.answer_log import AnswerLog, TooManyAnswers
from movingout.server.rooms.scheduler import RoomScheduler
from movingout.server.settings import Limits
from tests.server.live import Live, limits, raw_socket, serve

PROXY = ("127.0.0.1",)
SEATS = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}


def get(live: Live, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
    connection.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, body


@pytest.mark.slow
def test_10_a_flood_of_requests_is_refused_at_its_address_and_others_are_served(tmp_path: Path) -> None:
    with serve(tmp_path, limits(requests_per_address_per_s=1), trusted_proxies=PROXY) as live:
        found = [get(live, "/api/agents", X_Forwarded_For="10.0.0.1") for _ in range(40)]
        assert [status for status, _, _ in found].count(200) in (30, 31, 32)
        status, headers, body = found[-1]
        assert status == 429 and b"too_many_requests" in body
        assert headers["connection"] == "close" and "content-security-policy" in headers
        assert get(live, "/api/agents", X_Forwarded_For="10.0.0.2")[0] == 200
        assert live.host.admission.refusals["requests"] >= 8


def test_10_files_cost_a_quarter_of_a_request_and_unchanged_ones_are_not_sent_again(tmp_path: Path) -> None:
    with serve(tmp_path, limits(requests_per_address_per_s=1)) as live:
        _, headers, body = get(live, "/static/messages.js")
        assert headers["cache-control"] == "no-cache" and len(body) > 1000
        found = [get(live, "/static/messages.js", If_None_Match=headers["etag"]) for _ in range(100)]
        assert {(status, content) for status, _, content in found} == {(304, b"")}


def test_10_connections_that_are_made_and_dropped_are_not_accepted_for_ever(tmp_path: Path) -> None:
    with serve(tmp_path, limits(accepts_per_address_per_s=1)) as live:
        for _ in range(12):
            raw_socket(live).close()
        with raw_socket(live) as one_more:
            one_more.settimeout(5)
            with contextlib.suppress(ConnectionResetError):
                assert one_more.recv(100) == b""


def test_10_the_proxy_is_not_counted_as_an_address() -> None:
    """All connections come from it: its hundredth one is somebody else's first."""
    clock = [0.0]
    limited = replace(Limits(), connections_per_address=2, accepts_per_address_per_s=1)
    connections = ConnectionLimits(limited, ("127.0.0.1", "10.1.0.0/16"), lambda: clock[0])
    assert all(connections.opened("127.0.0.1") and connections.opened("10.1.7.7") for _ in range(100))
    assert [connections.opened("10.2.0.1") for _ in range(3)] == [True, True, False]
    assert [connections.opened(f"2001:db8::{last}") for last in range(3)] == [True, True, False], "one /64"
    assert is_trusted("::1", ("::1",)) and not is_trusted("unix", ("10.0.0.0/8",))
    assert not is_trusted("10.0.0.1", ("nonsense/x",))


def test_10_a_proxy_is_known_in_each_form_of_its_address() -> None:
    for proxies in (("192.0.2.1",), ("192.0.2.0/24",), ("::ffff:192.0.2.1",)):
        assert is_trusted("::ffff:192.0.2.1", proxies) and not is_trusted("::ffff:198.51.100.1", proxies)
    assert is_trusted("2001:db8::1", ("2001:db8:0::1",))
    assert both_forms(("192.0.2.1", "192.0.2.0/24", "2001:db8::/32")) == [
        *("192.0.2.1", "192.0.2.0/24", "2001:db8::/32"),
        *("::ffff:192.0.2.1", "::ffff:192.0.2.0/120"),
    ]


@pytest.mark.slow
def test_10_a_download_that_nobody_reads_is_dropped(tmp_path: Path) -> None:
    with serve(tmp_path, limits(unread_s=0.5)) as live:
        (live.host.settings.recordings / "large.mcap").write_bytes(b"0" * 20_000_000)
        with socket.socket() as client:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.settimeout(20)
            client.connect(("127.0.0.1", live.port))
            client.sendall(b"GET /api/recordings/large/file HTTP/1.1\r\nHost: x\r\n\r\n")
            time.sleep(2.0)
            received = 0
            with pytest.raises(ConnectionResetError):
                while part := client.recv(65536):
                    received += len(part)
                raise ConnectionResetError
            assert received < 10_000_000


def test_10_what_is_no_tick_keeps_no_lobby_closed_and_late_ticks_do() -> None:
    now = [0.0]
    scheduler = RoomScheduler(lambda: now[0])
    overload = Overload(scheduler, Limits(), lambda: now[0])
    for _ in range(10):
        now[0] += 1.0  # the process may be busy with whatever it is: no tick is late
        for _ in range(20):
            scheduler.lateness.add(0.2, 0)
        overload.sample()
    assert not overload.busy
    for _ in range(3):
        now[0] += 1.0
        for _ in range(20):
            scheduler.lateness.add(60.0, 0)
        overload.sample()
    assert overload.busy
    for _ in range(20):
        now[0] += 1.0
        overload.sample()
    assert not overload.busy
    scheduler.busy_s += 5.0
    now[0] += 1.0
    overload.sample()
    assert overload.busy, "the ticks take more than half of a core"


def test_10_one_address_cannot_fill_the_disk_in_a_day() -> None:
    now = [0.0]
    admission = AdmissionControl(replace(Limits(), recorded_per_address_per_day=1e6), lambda: now[0])
    admission.opened_room(admission.owner("10.0.0.1"), "room")
    admission.recorded("room", 800_000)
    assert admission.may_record("10.0.0.1")
    admission.recorded("room", 800_000)
    assert not admission.may_record("10.0.0.1") and admission.may_record("10.0.0.2")
    admission.recorded("of the operator", 10**12)
    now[0] += 12 * 3600.0
    assert admission.may_record("10.0.0.1")


@pytest.mark.slow
def test_10_rooms_beyond_the_rate_are_refused_before_any_other_room_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    ask = Host.ask

    async def counted(self: Host, room_id: str, *args: Any) -> Any:
        asked.append(room_id)
        return await ask(self, room_id, *args)

    monkeypatch.setattr(Host, "ask", counted)
    with serve(tmp_path, limits(rooms_per_address_per_minute=4, unjoined_rooms_per_address=50)) as live:
        for _ in range(4):
            live.open_room("here", "idle")
        before = len(asked)
        assert [live.call("/api/rooms", SEATS)[0] for _ in range(10)] == [429] * 10
        assert len(asked) == before


@pytest.mark.slow
def test_10_rounds_are_charged_to_the_address_that_opened_the_room(tmp_path: Path) -> None:
    with serve(tmp_path, limits(recorded_per_address_per_day=1000.0)) as live:
        room = live.open_room("here", "idle", limit_ticks=10)
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        person.say(type="ready", seat=0)
        person.wait_for("result")
        status, answer = live.call("/api/rooms", SEATS)
        assert (status, answer["error"]["code"]) == (429, "recorded_today")


@pytest.mark.slow
def test_an_answer_with_any_break_in_it_is_shown_again_and_hides_no_other(tmp_path: Path) -> None:
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")
        token, path = room["tokens"][0], f"/api/rooms/{room['room']}/answers"
        for question, text in (("comment", "copied\u2028[]\u2028from \x85 a slide"), ("teamwork", "")):
            answer = {"question": question, "value": -1 if text else 4, "text": text}
            assert live.call(path, answer, token)[0] == 200
        status, kept = live.call(path, token=token)
        assert (status, kept["answers"]["comment"]["text"]) == (200, "copied\u2028[]\u2028from \x85 a slide")
        assert kept["answers"]["teamwork"]["value"] == 4


def test_10_answers_of_one_seat_cannot_fill_the_disk(tmp_path: Path) -> None:
    log = AnswerLog(tmp_path)
    with pytest.raises(TooManyAnswers):
        for _ in range(1000):
            log.save("room", 0, "open", 0, "x" * 4000, 1.0)
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 400_000
