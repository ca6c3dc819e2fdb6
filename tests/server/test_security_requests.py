"""The threat table, slow and many requests, and what files and pages give away. Numbers are its rows."""

import http.client
import json
import re
import socket
import time
import urllib.error
import urllib.request
from pathlib import Path

import psutil
import pytest
from websockets.exceptions import InvalidStatus

from movingout.server import messages as m
from movingout.server import uvicorn_server
from movingout.server.api.middleware import content_security_policy
from movingout.server.api.pages import WEB
from movingout.server.connection import admission
from movingout.server.persistence import work_process
from movingout.server.security.certificate import certificate_in
from tests.server.live import ADMIN, WAIT_S, Live, handshake, limits, raw_socket, serve
from tests.server.threats import close_code, player

pytestmark = pytest.mark.slow

GHOST = {"maps": [], "seats": [{"kind": "ghost", "recording": "nothing"}, {"kind": "here"}]}

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


@pytest.mark.parametrize(
    "head",
    [b"GET /" + b"a" * 5_000 + b" HTTP/1.1\r\nHost: x\r\n\r\n",
     b"GET / HTTP/1.1\r\nHost: " + b"x" * 20_000 + b"\r\n\r\n",
     b"GET / HTTP/1.1\r\n" + b"".join(b"X-%d: %s\r\n" % (count, b"y" * 90) for count in range(200)) + b"\r\n"],
    ids=["address", "one header", "many headers"],
)  # fmt: skip
def test_9_a_head_that_is_too_long_is_refused(live: Live, head: bytes) -> None:
    with raw_socket(live) as client:
        client.sendall(head)
        client.settimeout(10)
        assert client.recv(2000).startswith(b"HTTP/1.1 431")
    assert live.call("/healthz")[0] == 200


def test_9_headers_without_end_fill_no_memory(live: Live) -> None:
    before = psutil.Process().memory_info().rss
    for head in (b"GET / HTTP/1.1\r\nHost: x\r\nX-Long: ", b"GET /"):
        with raw_socket(live) as client, pytest.raises(OSError):
            client.sendall(head)
            for _ in range(2_000):
                client.sendall(b"z" * 100_000)
    with raw_socket(live) as client, pytest.raises(OSError):  # after a body, where headers may come again
        client.sendall(b"POST /api/rooms HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n")
        for count in range(200_000):
            client.sendall(b"X-%d: %s\r\n" % (count, b"y" * 1_000))
    assert psutil.Process().memory_info().rss - before < 50e6
    assert live.call("/healthz")[0] == 200


def test_9_a_tls_client_that_says_nothing_is_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uvicorn_server, "TLS_HANDSHAKE_S", 0.5)
    certificate = certificate_in(tmp_path / "tls", "127.0.0.1")
    with serve(tmp_path, certificate=certificate) as live, raw_socket(live) as client:
        client.settimeout(10)
        assert _ends(client)


def test_10_replays_are_limited_per_address_and_those_at_hand_are_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "REPLAYS_PER_MINUTE", 3)
    with serve(tmp_path) as live:
        found = [live.call(f"/api/recordings/nothing-{count}") for count in range(5)]
    assert [status for status, _ in found] == [404, 404, 404, 429, 429]
    assert found[-1][1]["error"]["code"] == "too_many_replays"


def test_10_files_of_recordings_and_recorded_partners_count_as_replays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "REPLAYS_PER_MINUTE", 2)
    with serve(tmp_path) as live:
        assert live.call("/api/recordings/nothing/file")[0] == 404
        assert live.call("/api/rooms", GHOST)[0] == 422
        assert [live.call("/api/recordings/nothing/file")[0], live.call("/api/rooms", GHOST)[0]] == [429, 429]
        assert live.call("/api/recordings/nothing/file", token=ADMIN)[0] == 404


@pytest.mark.parametrize("path", ["/api/recordings/nothing", "/api/recordings/nothing/file", "ghost"])
def test_10_while_the_readers_are_busy_nobody_hears_that_there_is_nothing(
    live: Live, monkeypatch: pytest.MonkeyPatch, path: str
) -> None:
    monkeypatch.setattr(work_process, "MOST_WAITING", 0)
    body = GHOST if path == "ghost" else None
    status, answer = live.call(path if body is None else "/api/rooms", body)
    assert (status, answer["error"]["code"]) == (503, "readers_busy")


def test_10_who_may_ask_again_later_hears_when(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work_process, "MOST_WAITING", 0)
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(f"http://{live.address}/api/recordings/nothing", timeout=WAIT_S)
    refused.value.close()  # else a later test meets the warning
    assert (refused.value.code, refused.value.headers["retry-after"]) == (503, "60")


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
        assert [close_code(each) for each in waiting] == [m.CLOSE_RETRY_LATER] * 5, "a slow line may come again"
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
        assert answer["error"]["values"] == {"refusal": "rooms_in_use", "rooms": 2}


def test_10_a_busy_processor_opens_no_more_rooms(tmp_path: Path) -> None:
    with serve(tmp_path, limits(tick_share=0.5)) as live:
        live.host.overload.tick_share = 0.9
        status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]})
        assert status == 503 and "busy" in answer["error"]["message"]


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


def test_12_a_websocket_among_the_files_of_pages_is_refused_as_at_any_other_address(
    live: Live, caplog: pytest.LogCaptureFixture
) -> None:
    for path in ("/static/messages.js", "/nothing"):
        with raw_socket(live) as client:
            client.sendall(handshake(path))
            assert client.recv(100).startswith(b"HTTP/1.1 403")
    assert not caplog.records


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


REFUSED_BEFORE_THE_APPLICATION = {
    "cannot be parsed": (400, b"GET /\xff HTTP/1.1\r\nHost: x\r\n\r\n"),
    "too long a head": (431, b"GET / HTTP/1.1\r\nHost: x\r\nX: " + b"x" * 17_000 + b"\r\n\r\n"),
    "another site's name": (421, b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"),
    "two names": (400, b"GET / HTTP/1.1\r\nHost: x\r\nHost: y\r\n\r\n"),
    "a handshake without a key": (400, handshake().replace(b"sec-websocket-key", b"x-key")),
    "a handshake with a method of its own": (400, handshake().replace(b"GET", b"POST", 1)),
    "a handshake elsewhere": (403, handshake("/nothing")),
    "a handshake of another page": (403, handshake().replace(b"\r\n\r\n", b"\r\nOrigin: http://evil.example\r\n\r\n")),
}


@pytest.mark.parametrize(
    ("status", "request_"), REFUSED_BEFORE_THE_APPLICATION.values(), ids=REFUSED_BEFORE_THE_APPLICATION.keys()
)
def test_13_what_is_refused_before_the_application_carries_them_too(live: Live, status: int, request_: bytes) -> None:
    with raw_socket(live) as client, http.client.HTTPResponse(client) as answer:
        client.sendall(request_)
        answer.begin()
    assert answer.status == status
    assert answer.getheader("x-content-type-options") == "nosniff"
    assert answer.getheader("cache-control") == "no-store"
    assert "frame-ancestors 'none'" in str(answer.getheader("content-security-policy"))
    assert answer.getheader("date")
    assert all(len(answer.headers.get_all(name, [])) == 1 for name in answer.headers)


def test_13_no_page_holds_inline_script_or_style() -> None:
    pages = sorted(WEB.rglob("*.html"))
    assert len(pages) >= 8
    for page in pages:
        text = page.read_text()
        assert not re.search(r"<script(?![^>]*\bsrc=)", text), page.name
        assert not re.search(r"<style|\sstyle=|\son[a-z]+=|javascript:", text), page.name


def test_13_a_strange_host_does_not_get_into_the_policy() -> None:
    assert "evil" not in content_security_policy("x; script-src evil")
    assert "ws://[::1]:8000" in content_security_policy("[::1]:8000")
