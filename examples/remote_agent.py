"""A program that takes a seat, fetches one item and delivers it. Needs only `pip install websockets`.

    python examples/remote_agent.py ws://127.0.0.1:8000/ws ROOM

Create a room with a seat for a program, on the map Simple. docs/protocol.md explains every message.
"""

import asyncio
import json
import math
import struct
import sys

from websockets.asyncio.client import ClientConnection, connect

INPUT = struct.Struct("<BBIIIhhBBd")  # type 3, seat, seq, ticks received and shown, move, heading, grabs, device, ms
BUNDLE = struct.Struct("<BBHIdIIHHbbIBBB")  # type 1, flags, epoch, tick, ..., bodies, poses, events


def newest(frame: bytes) -> tuple[int, tuple[int, int], list[tuple[float, float, float]]]:
    """Tick, items held by blue and red, and the last pose (x, y, angle) of each body in a bundle."""
    head = BUNDLE.unpack_from(frame)
    tick, held, bodies = head[3], head[9:11], head[12]
    rows = struct.iter_unpack("<hhh", frame[BUNDLE.size : BUNDLE.size + head[13] * bodies * 6])
    return tick, held, [(x / 20000, y / 20000, angle * math.pi / 32768) for x, y, angle in rows][-bodies:]


def steering(seat: int, seq: int, tick: int, move: float, heading: float, grabs: int) -> bytes:
    """An input frame that answers the bundle of `tick`."""
    stick = round(move * 32767), round(heading * 32767 / math.pi)
    return INPUT.pack(3, seat, seq, tick, tick, *stick, grabs % 256, 3, 0.0)


async def carry(socket: ClientConnection, seat: int, item: int, home: tuple[float, float]) -> None:
    """Grab `item`, bring it `home`, let go. A heading of 0 looks up, counter-clockwise."""
    seq = grabs = pressed_at = 0
    async for frame in socket:
        if isinstance(frame, str) or frame[0] != 1:
            continue
        tick, held, poses = newest(frame)
        carrying, (x, y, angle) = held[seat] == item, poses[seat]
        to_x, to_y = home if carrying else poses[2 + item][:2]
        away, heading = math.hypot(to_x - x, to_y - y), math.atan2(x - to_x, to_y - y)
        in_reach = away < 0.195 and abs(math.remainder(heading - angle, 2 * math.pi)) < 0.1
        if (there := away < 0.05 if carrying else in_reach) and tick > pressed_at + 2:
            grabs, pressed_at = grabs + 1, tick
        move = 0.0 if there else 0.005 if away < 0.195 and not carrying else min(1.0, away / 0.12)
        seq += 1
        await socket.send(steering(seat, seq, tick, move, heading, grabs))
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
        await carry(socket, seat, item=seat, home=(0.9, 0.8) if seat else (-0.9, 0.8))
        await asyncio.sleep(0.5)  # let the last press arrive


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:])) if len(sys.argv) == 3 else sys.exit(__doc__)
