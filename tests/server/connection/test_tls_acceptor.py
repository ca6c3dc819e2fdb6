"""Silent TCP connections to a server with TLS count at once, and hold up nobody else."""

import contextlib
import json
import socket
import ssl
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import connect

from movingout.server import messages as m
from movingout.server import uvicorn_server
from movingout.server.security.certificate import Certificate, certificate_in
from tests.server.live import Live, limits, serve
from tests.server.processes.cluster import cluster

PER_ADDRESS = 5
AT_ONCE_S = 2.0  # far less than the time-out of a handshake, on a busy machine


@pytest.fixture
def certificate(tmp_path: Path) -> Certificate:
    return certificate_in(tmp_path / "tls", "127.0.0.1")


@contextlib.contextmanager
def silent(live: Live, addresses: list[str]) -> Iterator[list[socket.socket]]:
    """Connections that say nothing, one from each address."""
    with contextlib.ExitStack() as stack:
        yield [
            stack.enter_context(socket.create_connection(("127.0.0.1", live.port), 10, (address, 0)))
            for address in addresses
        ]


def ended(connections: list[socket.socket]) -> int:
    """How many the server has closed."""
    count = 0
    for connection in connections:
        connection.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            with contextlib.suppress(ConnectionError):
                assert connection.recv(1) == b""
            count += 1
    return count


def wait_until(holds: Callable[[], bool]) -> None:
    until = time.monotonic() + AT_ONCE_S
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.02)


def healthy(live: Live, certificate: Certificate) -> bool:
    context = ssl.create_default_context(cafile=str(certificate.certificate))
    with urllib.request.urlopen(f"https://{live.address}/healthz", None, AT_ONCE_S, context=context) as answer:
        return bool(json.load(answer)["ok"])


@pytest.mark.slow
@pytest.mark.parametrize("server", [serve, cluster])
def test_silent_connections_count_for_their_address_and_hold_up_nobody_else(
    server: Callable[..., Any], certificate: Certificate, tmp_path: Path
) -> None:
    few = limits(connections_per_address=PER_ADDRESS)
    with server(tmp_path, limits=few, certificate=certificate, tls=True) as live:
        with silent(live, ["127.0.0.2"] * 60) as connections:
            assert healthy(live, certificate)
            wait_until(lambda: ended(connections) == 60 - PER_ADDRESS)
            assert live.host.admission.refusals["connection"] == 60 - PER_ADDRESS
        with silent(live, ["127.0.0.2"] * PER_ADDRESS) as connections:
            time.sleep(0.2)
            assert ended(connections) == 0, "those that hung up are counted no more"


def test_silent_connections_from_many_addresses_make_way_for_new_ones(
    certificate: Certificate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uvicorn_server, "most_connections", lambda limits: 40)
    addresses = [f"127.0.1.{number}" for number in range(1, 101)]
    with serve(tmp_path, certificate=certificate) as live, silent(live, addresses) as connections:
        assert healthy(live, certificate)
        wait_until(lambda: ended(connections) >= 90)
        assert ended(connections[-5:]) == 0, "the oldest go first"


def test_handshakes_cost_more_than_plain_connections(certificate: Certificate, tmp_path: Path) -> None:
    few = limits(accepts_per_address_per_s=1.0)  # ten at once
    with serve(tmp_path, few, certificate=certificate) as live, silent(live, ["127.0.0.2"] * 9) as connections:
        wait_until(lambda: ended(connections) == 5)


def test_an_address_typed_without_https_leads_there(certificate: Certificate, tmp_path: Path) -> None:
    def answer(host: str, start: bytes = b"GET /play/x?lang=de HTTP/1.1\r\n") -> bytes:
        with socket.create_connection(("127.0.0.1", live.port), 10) as plain:
            plain.sendall(start + f"Host: {host}\r\nAccept: */*\r\n\r\n".encode())
            with contextlib.suppress(ConnectionError):
                return plain.recv(4096)
        return b""

    with serve(tmp_path, certificate=certificate, tls=True) as live:
        head = answer(f"127.0.0.1:{live.port}").decode()
        assert head.startswith("HTTP/1.1 307 "), "not kept: the next server may be one without TLS"
        assert f"\r\nlocation: https://127.0.0.1:{live.port}/play/x?lang=de\r\n" in head
        for host in ("evil.example.org", "127.0.0.1:1\r\nHost: 127.0.0.1:2", "a b"):
            assert b"HTTP/1.1 307" not in answer(host)
        assert b"HTTP/1.1 307" not in answer("127.0.0.1", b"POST / HTTP/1.1\r\n")
        assert healthy(live, certificate)


@pytest.mark.slow
def test_connections_are_counted_out_when_they_end(certificate: Certificate, tmp_path: Path) -> None:
    context = ssl.create_default_context(cafile=str(certificate.certificate))
    with serve(tmp_path, limits(connections_per_address=2), certificate=certificate) as live:
        for _ in range(4):
            with socket.create_connection(("127.0.0.1", live.port), 10) as plain:
                plain.sendall(b"GET / HTTP/1.1\r\n\r\n")
                plain.recv(100)
            assert healthy(live, certificate)
            link = connect(
                f"wss://{live.address}/ws",
                subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
                ssl=context,
                origin=f"https://{live.address}",  # type: ignore[arg-type]
            )
            live.connections.append(link)  # a websocket is counted elsewhere, also while it is open
