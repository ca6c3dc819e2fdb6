"""A server for clients of programs that says what a test has written, instead of playing a round."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import numpy as np
from msgspec import to_builtins
from websockets.asyncio.server import ServerConnection, serve

from movingout.maps import load_map
from movingout.maps.json_format import map_to_json
from movingout.server.frames import FRAME_FIELDS
from tests.server.support import make_bundle

RESULT = {"type": "result", "outcome": "delivered", "ticks": 16, "metrics": {}, "recording": ""}
PINGS = [
    {"type": "ping", "epoch": epoch, "tick": 3, "seat": 1, "item": 1, "x": 0.5, "y": -0.5, "ticks": 20}
    for epoch in (1, 2)
]  # one of another round
REFUSAL = {"type": "error", "code": "ready_rate", "message": "too many changes; wait a second", "values": {}}
BETWEEN_S = 0.05  # two messages that the server writes at once arrive apart on a slow line


def room_state(phase: str, reason: str = "") -> dict[str, Any]:
    return {"type": "room", "phase": phase, "reason": reason}


def round_with_pings() -> list[dict[str, Any] | bytes]:
    """A round of 24 ticks of which a few arrive; the partner asks for help before the third."""
    the_map = load_map("Simple")
    bundles = [
        make_bundle(epoch=1, tick=tick, poses=np.zeros((5, 2 + len(the_map.items), 3))).encode()
        for tick in (2, 3, 22, 23)
    ]
    begin = {"type": "round", "map": map_to_json(the_map), "limit_ticks": 24, "epoch": 1}
    return [begin, room_state("playing"), bundles[0], *PINGS, *bundles[1:], RESULT, room_state("series_over")]


@asynccontextmanager
async def program_room(*said: dict[str, Any] | bytes, heard: list[str | bytes] | None = None) -> AsyncIterator[str]:
    """The address of a room that says this to its program once it is ready; what comes then is `heard`."""

    async def speak(socket: ServerConnection) -> None:
        seats = [{"seat": 0, "token": "t"}]
        await socket.send(json.dumps({"type": "welcome", "seats": seats, "frames": to_builtins(FRAME_FIELDS)}))
        await socket.send(json.dumps(room_state("lobby")))
        await socket.recv()  # join
        await socket.recv()  # ready
        for message in said:
            await socket.send(message if isinstance(message, bytes) else json.dumps(message))
            await asyncio.sleep(BETWEEN_S)
        async for answer in socket:
            if heard is not None:
                heard.append(answer)

    async with serve(speak, "127.0.0.1", 0, subprotocols=["movingout.v1"]) as server:  # type: ignore[list-item]
        yield f"http://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"
