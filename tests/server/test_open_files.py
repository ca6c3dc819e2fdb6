"""Idle connections from many addresses leave the server the files that it needs for journals, agents and databases."""

import contextlib
import json
import socket
import subprocess
import sys
import time
import urllib.request
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from websockets.sync.client import ClientConnection, connect

from movingout.server import messages as m
from movingout.server.connection.connection_limits import ConnectionLimits
from movingout.server.settings import Limits
from tests.server.live import Person

FILES, ROOMS = 300, 10
MOST = FILES - 200 - ROOMS  # 200 are the program's own
ADDRESSES, EACH = 8, 50


@contextlib.contextmanager
def served(data: Path) -> Iterator[tuple[int, psutil.Process]]:
    """A server that may open few files: its port and its process."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = f'ulimit -n {FILES}; exec "$@"'
    play = [sys.executable, "-P", "-m", "movingout.server.cli", "play", "--port", str(port), "--data", str(data)]
    play += ["--processes", "1", "--max-rooms", str(ROOMS), "--agent-workers", "1"]
    with subprocess.Popen(["sh", "-c", command, "sh", *play], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert any(b"Admin token" in line for line in process.stdout)
            yield port, psutil.Process(process.pid)
        finally:
            process.terminate()
            process.wait(60)


def idle(stack: contextlib.ExitStack, port: int, address: str) -> None:
    for _ in range(EACH):
        with contextlib.suppress(OSError):
            stack.enter_context(socket.create_connection(("127.0.0.1", port), 5, source_address=(address, 0)))


@pytest.mark.slow
def test_idle_connections_of_many_addresses_cost_no_round_its_recording(tmp_path: Path) -> None:
    with served(tmp_path) as (port, process), contextlib.ExitStack() as stack:
        seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
        body = json.dumps({"maps": ["Simple"], "seats": seats, "limit_ticks": 20}).encode()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/rooms", body, 20) as answer:
            room = json.load(answer)
        link: ClientConnection = connect(
            f"ws://127.0.0.1:{port}/ws/{room['room']}",
            subprotocols=[m.SUBPROTOCOL],  # type: ignore[list-item]
        )
        stack.callback(link.close)
        person = Person(link, room["room"], tokens=room["tokens"][:1])
        for number in range(ADDRESSES):
            idle(stack, port, f"127.0.1.{number + 1}")
        time.sleep(0.5)
        assert process.num_fds() <= MOST + 100
        person.say(type="ready", seat=0)
        result = person.play_out()
        assert (result["ticks"], bool(result["recording"])) == (20, True)


def test_a_connection_beyond_all_that_there_may_be_is_refused_whoever_comes() -> None:
    websockets, refusals = [0], Counter[str]()
    connections = ConnectionLimits(
        Limits(), ("10.0.0.1",), lambda: 0.0, refusals, most=4, websockets=lambda: websockets[0]
    )
    assert [connections.opened(f"192.0.2.{number}") for number in range(5)] == [True] * 4 + [False]
    assert not connections.opened("10.0.0.1"), "a proxy's connections are files, too"
    for address in ("10.0.0.1", "192.0.2.4", "192.0.2.0"):
        connections.closed(address)
    assert connections.opened("10.0.0.1")
    connections.closed("10.0.0.1")
    websockets[0] = 1
    assert not connections.opened("192.0.2.9")
    assert refusals["connection"] == 3
