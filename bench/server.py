"""Rooms per server: 100 and 200 rooms with two clients each, and 50 rooms beside a client that floods.

Lateness is measured by the server over SECONDS of steady play; bots play from this process. Run nothing else:
`canary` shows how late an idle loop wakes up on this machine.
"""

import asyncio
import contextlib
import json
import time

import msgspec

from movingout.server import messages as m
from movingout.server.commands.load_client import BINARY, TEXT, handshake, masked
from movingout.server.commands.loadtest import RunningServer, measure, open_room, running_server
from movingout.server.frames import Input
from movingout.server.rooms.lateness import Lateness

SECONDS = 20.0
GOALS = {100: {"p99": 2.0, "p999": 10.0}, 200: {"p99": 5.0}}
ABUSED_ROOMS = 50
ABUSED_P99 = 5.0


def main() -> None:
    print(f"canary: {json.dumps(canary())}")
    for rooms, goals in GOALS.items():
        with running_server(rooms, 2) as target:
            _print(f"{rooms} rooms x 2", measure(target, rooms, 2, SECONDS), goals)
    with running_server(ABUSED_ROOMS, 3) as target:
        result = measure(target, ABUSED_ROOMS, 2, SECONDS, beside=abuse)
        _print(f"{ABUSED_ROOMS} rooms x 2 beside one that floods", result, {"p99": ABUSED_P99})


def canary() -> dict[str, float]:
    """How late a sleeping loop wakes up, over 3 s: the lateness of the machine itself."""
    lateness = Lateness()

    async def wake() -> None:
        due = time.monotonic()
        for _ in range(600):
            due += 0.005
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            lateness.add(max(0.0, time.monotonic() - due) * 1e3, 0)

    asyncio.run(wake())
    return lateness.report()


async def abuse(target: RunningServer) -> None:
    """Watch a room, flood the socket until cut off, and reconnect; until cancelled."""
    room = await asyncio.to_thread(open_room, target, "Simple", 1)
    flood = masked(BINARY, Input(0, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode()) * 200
    host, port = target.host_and_port
    while True:
        with contextlib.suppress(OSError, EOFError):
            reader, writer = await asyncio.open_connection(host, port)
            writer.write(handshake(f"{host}:{port}", room))
            await reader.readuntil(b"\r\n\r\n")
            writer.write(masked(TEXT, msgspec.json.encode(m.Join(room, "watch"))))
            for _ in range(50):
                writer.write(flood)
                await writer.drain()
            writer.close()
        await asyncio.sleep(0.02)


def _print(name: str, result: dict[str, object], goals: dict[str, float]) -> None:
    late = result["late_ms"]
    assert isinstance(late, dict)
    reached = all(late[share] < goal for share, goal in goals.items()) and result["missed_ticks"] == 0
    wanted = ", ".join(f"{share} < {goal:g} ms" for share, goal in goals.items())
    print(f"{name}: {'reached' if reached else 'NOT reached'} ({wanted}, none missed)")
    print(f"  {json.dumps(result)}")
