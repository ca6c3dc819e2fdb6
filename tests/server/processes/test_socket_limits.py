"""Limits on websockets of one address hold for all processes together, and nothing is counted of one that has died."""

import os
import signal
import time
from collections.abc import Iterator
from typing import cast

import pytest
from websockets.exceptions import InvalidStatus

from movingout.server.connection.admission import FLOODS_PER_MINUTE
from movingout.server.processes import room_link
from movingout.server.processes.front import Front
from movingout.server.processes.homes import home_of
from movingout.server.uvicorn_server import GameServer
from tests.server.live import Live, handshake, limits, raw_socket, wait_until
from tests.server.processes.cluster import cluster, links

MOST = 4
HERE = "127.0.0.1"


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with cluster(tmp_path_factory.mktemp("limits"), limits=limits(sockets_per_address=MOST)) as live:
        yield live


@pytest.fixture
def rooms(live: Live) -> Iterator[list[str]]:
    """A room in each process."""
    found: dict[int, str] = {}
    while len(found) < len(links(live)):
        room = live.open_room("here", "link")["room"]
        found.setdefault(home_of(room, len(links(live))), room)
    yield [found[index] for index in sorted(found)]
    live.hang_up()


def counted(live: Live, number: int) -> None:
    """Wait until the front knows of so many, and that all have joined."""
    deadline = time.monotonic() + 60.0

    def known() -> tuple[int, int]:
        counts = [link.sockets for link in links(live)]
        return sum(one.open.get(HERE, 0) for one in counts), sum(one.waiting.get(HERE, 0) for one in counts)

    while known() != (number, 0):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def refused(live: Live, room: str) -> str:
    with pytest.raises(InvalidStatus) as caught:
        live.connect(room)
    assert caught.value.response.status_code == 503
    return caught.value.response.body.decode()


@pytest.mark.slow
def test_an_address_has_its_sockets_in_all_processes_together(live: Live, rooms: list[str]) -> None:
    counted(live, 0)
    for number in range(MOST):
        live.person(rooms[number % 2], mode="watch")
    counted(live, MOST)
    for room in rooms:
        assert f"There are {MOST} connections from your address already" in refused(live, room)
    live.hang_up()
    counted(live, 0)
    live.person(rooms[0], mode="watch")
    counted(live, 1)


@pytest.mark.slow
def test_the_sockets_of_a_killed_process_are_no_longer_counted(live: Live, rooms: list[str]) -> None:
    counted(live, 0)
    live.person(rooms[0], mode="watch")
    live.person(rooms[1], mode="watch")
    counted(live, 2)
    os.kill(links(live)[0].pid, signal.SIGKILL)
    counted(live, 1)


def test_a_websocket_counts_while_it_waits_for_its_process(
    live: Live, rooms: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room_link, "HOME_S", 60.0)
    link, connections = links(live)[0], cast(GameServer, live.server)._connections
    wait_until(lambda: connections._total == 0)
    live.run(link._ready.clear)
    with raw_socket(live) as client:
        client.sendall(handshake(f"/ws/{rooms[0]}"))
        wait_until(lambda: connections._total == 1)
        live.run(link._ready.set)
        assert client.recv(100).startswith(b"HTTP/1.1 101")
        wait_until(lambda: connections._total == 0)


def test_who_floods_one_process_is_kept_out_of_all(live: Live, rooms: list[str]) -> None:
    front = cast(Front, live.host)
    for _ in range(FLOODS_PER_MINUTE + 1):
        links(live)[0].socket_changed("flooded", HERE)
    try:
        for room in rooms:
            assert "have flooded this server" in refused(live, room)
    finally:
        front.admission._banned.clear()
