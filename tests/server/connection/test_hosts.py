"""Under which names a server answers."""

import http.client
import os
import socket
import threading
from pathlib import Path

import pytest

from movingout.server import messages as m
from movingout.server.connection import hosts
from movingout.server.connection.hosts import host_allowed
from movingout.server.settings import Settings
from tests.server.live import WAIT_S, Live, raw_socket, serve, wait_until


def allowed(host: str, **settings: object) -> bool:
    return host_allowed([(b"host", host.encode("latin-1"))], Settings(**settings))  # type: ignore[arg-type]


@pytest.mark.parametrize("host", ["localhost:8000", "127.0.0.1:1", "[::1]:8000", "192.168.0.4", "labpc", "labpc.local"])
def test_addresses_and_names_that_nobody_can_register_are_this_servers(host: str) -> None:
    assert allowed(host)


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example:8000", "", "a" * 5000, "x y", "a\r\nb", "[::1", "host:99999999"]
)
def test_a_name_of_another_site_is_refused(host: str) -> None:
    assert not allowed(host)
    assert not allowed(host, trusted_proxies=("127.0.0.1",), allowed_hosts=("study.example.org",))


def test_the_name_that_the_operator_gave_is_answered_and_behind_a_proxy_any_is() -> None:
    assert allowed("study.example.org", allowed_hosts=("study.example.org",))
    assert allowed("Study.Example.org:443", allowed_hosts=("study.example.org",))
    assert allowed("study.example.org", trusted_proxies=("127.0.0.1",))


def test_a_page_whose_name_was_pointed_here_opens_no_room_and_no_socket(live: Live) -> None:
    """DNS rebinding: the browser sends the attacker's name as Host and as Origin."""
    head = b"Host: evil.example\r\nOrigin: http://evil.example\r\n"
    upgrade = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    upgrade += b"Sec-WebSocket-Version: 13\r\n"
    before = len(live.rooms)
    for request in (
        b"POST /api/rooms HTTP/1.1\r\n" + head + b"Content-Length: 2\r\n\r\n{}",
        b"GET /ws HTTP/1.1\r\n" + head + upgrade + b"\r\n",
        b"GET / HTTP/1.1\r\nHost: " + b"a" * 5000 + b"\r\n\r\n",
    ):
        with raw_socket(live) as client:
            client.sendall(request)
            assert client.recv(3000).startswith(b"HTTP/1.1 421"), request[:20]
    assert len(live.rooms) == before


def test_a_request_with_several_hosts_is_refused_wherever_its_host_is_used(live: Live) -> None:
    """A proxy that goes by the last one would let the first one through."""
    upgrade = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    upgrade += b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: " + m.SUBPROTOCOL.encode() + b"\r\n"
    for second in (b"evil.example", b"127.0.0.1", b""):
        hosts = b"Host: 127.0.0.1\r\nhost: " + second + b"\r\n"
        for line, more in (
            (b"GET / ", b"\r\n"),
            (b"POST /api/rooms ", b"Content-Length: 2\r\n\r\n{}"),
            (b"GET /ws ", upgrade + b"\r\n"),
        ):
            with raw_socket(live) as client:
                client.sendall(line + b"HTTP/1.1\r\n" + hosts + more)
                answer = b"".join(iter(lambda: client.recv(10_000), b""))
            assert answer.startswith(b"HTTP/1.1 400") and b"several Host headers" in answer, answer


def test_no_request_waits_until_the_dns_says_what_this_machine_is_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first strange Host made the server ask, and every game wait for the answer."""
    answers = threading.Event()

    def full_name() -> str:
        answers.wait(WAIT_S)
        return "LabPC.uni.example"

    def is_known(live: Live) -> bool:
        with raw_socket(live) as client:
            client.sendall(b"GET / HTTP/1.1\r\nHost: labpc.uni.example:8000\r\n\r\n")
            status = client.recv(3000)[:12]
        assert status in (b"HTTP/1.1 200", b"HTTP/1.1 421")
        return status.endswith(b"200")

    monkeypatch.setattr(hosts, "_own_names", set())
    monkeypatch.setattr(socket, "getfqdn", full_name)
    with serve(tmp_path) as live:
        assert not is_known(live) and not answers.is_set()
        answers.set()
        wait_until(lambda: is_known(live))


@pytest.mark.slow
def test_a_very_long_name_is_refused_shortly_and_fills_no_log(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """D16: it was answered with itself, twice, or with a fault and a traceback."""
    upgrade = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    for proxies in ((), ("127.0.0.1",)):
        with serve(tmp_path / str(len(proxies)), trusted_proxies=proxies) as live:
            for path, more in ((b"/", b""), (b"/api/rooms", b""), (b"/ws", upgrade + b"Sec-WebSocket-Version: 13\r\n")):
                with raw_socket(live) as client:
                    client.sendall(b"GET " + path + b" HTTP/1.1\r\nHost: " + b"a" * 5000 + b"\r\n" + more + b"\r\n")
                    answer = b"".join(iter(lambda: client.recv(10_000), b""))
                assert answer.startswith(b"HTTP/1.1 421") and len(answer) < 1000, answer
    assert sum(len(record.getMessage()) for record in caplog.records) < 1000
    assert not any(record.exc_info for record in caplog.records)


@pytest.mark.slow
def test_https_behind_a_proxy_is_for_good(tmp_path: Path) -> None:
    found = {}
    for proxies in ((), ("127.0.0.1",)):
        with serve(tmp_path / str(len(proxies)), trusted_proxies=proxies) as live:
            connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
            connection.request("GET", "/healthz", headers={"X-Forwarded-Proto": "https", "Host": "study.example.org"})
            answer = connection.getresponse()
            answer.read()
            found[proxies] = answer.getheader("strict-transport-security")
            connection.close()
    assert found == {(): None, ("127.0.0.1",): "max-age=31536000"}


def test_files_of_a_server_are_for_its_owner_alone(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        with serve(tmp_path) as live:
            live.open_room("here", "idle")
            live.run(live.host.store.flush)
        kept = [path for path in tmp_path.rglob("*") if path.is_file()]
        assert kept and not [path for path in kept if path.stat().st_mode & 0o077]
    finally:
        os.umask(before)
