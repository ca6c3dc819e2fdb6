"""A program that takes a seat, fetches one item and delivers it. Needs only `pip install websockets`.

    python examples/remote_agent.py ws://127.0.0.1:8000/ws ROOM

Create a room with a seat for a program, on the map Simple. docs/protocol.md explains every message.
"""

import asyncio
import json
import math
import struct
import sys
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

Frames = dict[str, Any]  # per frame its `format` and the `names` of its numbers, from the welcome


def newest(frames: Frames, frame: bytes) -> tuple[int, tuple[int, int], list[tuple[float, float, float]]]:
    """Tick, items held by blue and red, and the last pose (x, y, angle) of each body in a bundle."""
    start, pose = (struct.Struct(frames[name]["format"]) for name in ("bundle", "pose"))
    head = dict(zip(frames["bundle"]["names"], start.unpack_from(frame), strict=True))
    end = start.size + head["pose_count"] * head["bodies"] * pose.size
    poses = [(x / 20000, y / 20000, a * math.pi / 32768) for x, y, a in pose.iter_unpack(frame[start.size : end])]
    return head["tick"], (head["held_blue"], head["held_red"]), poses[-head["bodies"] :]


def steering(frames: Frames, tick: int, move: float, heading: float, **numbers: int) -> bytes:
    """An input frame that answers the bundle of `tick`, with `seat`, `seq` and `grabs`; what it does not name is 0."""
    numbers |= {"move": round(move * 32767), "heading": round(heading * 32767 / math.pi), "device": 3}
    numbers |= {"type": 3, "ack_tick": tick, "seen_tick": tick}
    return struct.pack(frames["input"]["format"], *(numbers.get(name, 0) for name in frames["input"]["names"]))


async def carry(socket: ClientConnection, frames: Frames, seat: int, item: int, home: tuple[float, float]) -> None:
    """Grab `item`, bring it `home`, let go. A heading of 0 looks up, counter-clockwise."""
    seq = grabs = pressed_at = 0
    async for frame in socket:
        if isinstance(frame, str) or frame[0] != 1:
            continue
        tick, held, poses = newest(frames, frame)
        carrying, (x, y, angle) = held[seat] == item, poses[seat]
        to_x, to_y = home if carrying else poses[2 + item][:2]
        away, heading = math.hypot(to_x - x, to_y - y), math.atan2(x - to_x, to_y - y)
        in_reach = away < 0.195 and abs(math.remainder(heading - angle, 2 * math.pi)) < 0.1
        if (there := away < 0.05 if carrying else in_reach) and tick > pressed_at + 2:
            grabs, pressed_at = grabs + 1, tick
        move = 0.0 if there else 0.005 if away < 0.195 and not carrying else min(1.0, away / 0.12)
        seq += 1
        await socket.send(steering(frames, tick, move, heading, seat=seat, seq=seq, grabs=grabs % 256))
        if there and carrying:
            return


async def main(address: str, room: str) -> None:
    async with connect(address, subprotocols=["movingout.v1"]) as socket:  # type: ignore[list-item]
        await socket.send(json.dumps({"type": "join", "room": room, "claim": 1, "program": True, "name": "example"}))
        welcome = json.loads(await socket.recv())
        if welcome["type"] != "welcome":
            sys.exit(welcome["message"])
        seat = welcome["seats"][0]["seat"]
        await socket.send(json.dumps({"type": "ready", "seat": seat}))
        await carry(socket, welcome["frames"], seat, item=seat, home=(0.9, 0.8) if seat else (-0.9, 0.8))
        await asyncio.sleep(0.5)  # let the last press arrive


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:])) if len(sys.argv) == 3 else sys.exit(__doc__)
