"""TLS with several processes: a connection reaches the process of its room at the second try, without a proxy."""

import contextlib
import json
import ssl
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from movingout.server import messages as m
from movingout.server.security.certificate import certificate_in
from tests.server.live import Live, Person
from tests.server.processes.cluster import cluster

MOST_TRIES = 10


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Live, ssl.SSLContext]]:
    data = tmp_path_factory.mktemp("tls")
    certificate = certificate_in(data / "tls", "127.0.0.1")
    context = ssl.create_default_context(cafile=str(certificate.certificate))
    with cluster(data, certificate=certificate, tls=True) as live:
        yield live, context


def call(served: tuple[Live, ssl.SSLContext], path: str, body: object = None) -> Any:
    live, context = served
    data = None if body is None else json.dumps(body).encode()
    with urllib.request.urlopen(f"https://{live.address}{path}", data, 20, context=context) as answer:
        return json.load(answer)


def sit(served: tuple[Live, ssl.SSLContext], room: str, token: str) -> tuple[Person, int]:
    """A person at a seat, as pages do it: connects again as long as it is told to. And the number of tries."""
    live, context = served
    for tries in range(1, MOST_TRIES):
        connection: ClientConnection = connect(
            f"wss://{live.address}/ws/{room}",
            subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
            ssl=context,
            origin=f"https://{live.address}",  # type: ignore[arg-type]
        )
        live.connections.append(connection)
        with contextlib.suppress(ConnectionClosed):
            return Person(connection, room, tokens=[token]), tries
        assert connection.close_code == m.CLOSE_RETRY
    raise AssertionError("the process of the room was never reached")


@pytest.mark.slow
def test_rooms_are_played_over_tls_in_whichever_process(served: tuple[Live, ssl.SSLContext]) -> None:
    for _ in range(2):
        seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
        room = call(served, "/api/rooms", {"maps": ["Simple"], "seats": seats, "limit_ticks": 20})
        person, tries = sit(served, room["room"], room["tokens"][0])
        assert tries >= 2, "the first one comes to the front; on a busy machine the next may be too late to be expected"
        person.say(type="ready", seat=0, ready=True)
        assert person.play_out()["ticks"] == 20


@pytest.mark.slow
def test_a_request_that_comes_to_a_process_with_rooms_is_sent_to_the_front(
    served: tuple[Live, ssl.SSLContext],
) -> None:
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    room = call(served, "/api/rooms", {"maps": ["Simple"], "seats": seats})
    live, context = served
    with (
        pytest.raises(ConnectionClosed),
        connect(
            f"wss://{live.address}/ws/{room['room']}",
            subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
            ssl=context,
            origin=f"https://{live.address}",  # type: ignore[arg-type]
        ) as connection,
    ):
        while True:
            connection.recv(20)
    assert call(served, "/healthz")["ok"]  # the connection that was expected in another process
    assert call(served, f"/api/rooms/{room['room']}")["map"] == "Simple"


def test_what_is_no_tls_disturbs_nobody(served: tuple[Live, ssl.SSLContext], tmp_path: Path) -> None:
    import socket

    live, _ = served
    with socket.create_connection(("127.0.0.1", live.port), 10) as plain:
        plain.sendall(b"GET / HTTP/1.1\r\n\r\n")
        assert plain.recv(100)[:4] != b"HTTP"
    assert call(served, "/healthz")["ok"]
