"""Who has opened a room is kept with it: the limits of an address hold after a restart, a kill and a takeover, too."""

import json
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import msgspec
import pytest

from movingout.server.persistence.room_store import RoomFile
from movingout.server.settings import Limits
from tests.server.live import ADMIN, Live, limits, serve
from tests.server.processes.cluster import cluster

SEATS = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]}
FEW = limits(open_rooms_per_address=3, unjoined_rooms_per_address=2)
NETWORK, NEIGHBOUR, STRANGER = "2001:db8::1", "2001:db8::2", "2001:db8:0:1::1"


def opened(live: Live, address: str) -> int:
    return live.call("/api/rooms", SEATS, **{"X-Forwarded-For": address})[0]


@pytest.mark.slow
@pytest.mark.parametrize("served", [serve, cluster], ids=["one process", "two"])
def test_after_a_restart_an_address_has_the_rooms_that_it_had(
    tmp_path: Path, served: Callable[..., AbstractContextManager[Live]]
) -> None:
    with served(tmp_path, limits=FEW, trusted_proxies=("127.0.0.1",)) as live:
        assert [opened(live, NETWORK) for _ in range(3)] == [200, 200, 429], "two that nobody has joined"
        assert live.call("/api/rooms", SEATS, token=ADMIN)[0] == 200, "nobody's"
    with served(tmp_path, limits=FEW, trusted_proxies=("127.0.0.1",)) as live:
        assert opened(live, NEIGHBOUR) == 429, "nobody has joined them meanwhile"
        assert opened(live, STRANGER) == 200
        rows = live.call("/api/admin/state", token=ADMIN)[1]["rooms"]
        assert sorted(row["rooms_of_address"] for row in rows) == [0, 1, 2, 2]
        first = next(row["room"] for row in rows if row["rooms_of_address"] == 2)
        assert live.call(f"/api/admin/rooms/{first}/close-address", {}, token=ADMIN) == (200, {"closed": 2})
        assert opened(live, NETWORK) == 200, "closed ones do not count"


def test_the_file_of_a_room_names_no_address(tmp_path: Path) -> None:
    with serve(tmp_path, trusted_proxies=("127.0.0.1",)) as live:
        assert opened(live, "192.0.2.77") == 200
    [path] = (tmp_path / "rooms").glob("*.json")
    assert b"192.0.2" not in path.read_bytes()
    assert len(msgspec.json.decode(path.read_bytes(), type=RoomFile).config.owner) == 24


@pytest.mark.slow
def test_the_file_of_an_earlier_version_is_understood(tmp_path: Path) -> None:
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")["room"]
    path = tmp_path / "rooms" / f"{room}.json"
    file = json.loads(path.read_bytes())
    del file["joined"], file["config"]["owner"]
    path.write_text(json.dumps(file), encoding="utf-8")
    with serve(tmp_path) as live:
        assert [(room.id, room.was_joined, room.config.owner) for room in live.rooms] == [(room, True, "")]


@contextmanager
def killed_in_the_end(data: Path, port: int, processes: int) -> Iterator[None]:
    command = [sys.executable, "-P", "-m", "movingout.server.cli", "play", "--port", str(port), "--data", str(data)]
    command += ["--processes", str(processes), "--agent-workers", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert any(b"Admin token" in line for line in process.stdout)
            yield
        finally:
            process.send_signal(signal.SIGKILL)


def status_of_opening(port: int) -> int:
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/rooms", json.dumps(SEATS).encode(), 20) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 2])
def test_a_killed_server_forgets_no_room_of_an_address(tmp_path: Path, processes: int) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    most = Limits().unjoined_rooms_per_address
    with killed_in_the_end(tmp_path, port, processes):
        assert [status_of_opening(port) for _ in range(most + 1)] == [200] * most + [429]
    with killed_in_the_end(tmp_path, port, processes):
        assert status_of_opening(port) == 429
