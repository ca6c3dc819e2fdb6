"""Floods against a server on this machine, from an address of their own: 127.0.0.2, which shares no limit with players.

Each goes on until it is cancelled, at most SECONDS. One alone: `python -m tests.attacks.floods NAME ADDRESS ROOM`.
"""

import asyncio
import base64
import contextlib
import json
import os
import struct
import sys
from collections.abc import Awaitable, Callable
from typing import NamedTuple
from urllib.parse import urlsplit

from movingout.server import messages as m
from movingout.server.commands.load_client import BINARY, TEXT, masked
from movingout.server.frames import Input

SECONDS = 60.0
FROM = ("127.0.0.2", 0)
PONG, CONTINUATION, PART = 0x8A, 0x00, 0x01
CONNECTIONS = 8


class Target(NamedTuple):
    """Where the server is, and a room that can be watched."""

    host: str
    port: int
    room: str


async def connect(target: Target) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    return await asyncio.open_connection(target.host, target.port, local_addr=FROM)


async def watch(target: Target) -> asyncio.StreamWriter:
    """A websocket that watches the room."""
    _, writer = await join(target, {"mode": "watch"})
    return writer


async def join(target: Target, request: dict[str, object]) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """A websocket whose first message is this join."""
    reader, writer = await connect(target)
    key = base64.b64encode(os.urandom(16)).decode()
    writer.write(
        f"GET /ws/{target.room} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: {m.SUBPROTOCOL}\r\n\r\n".encode()
    )
    await reader.readuntil(b"\r\n\r\n")
    writer.write(masked(TEXT, json.dumps({"type": "join", "room": target.room} | request).encode()))
    return reader, writer


async def send_frames(target: Target, first: bytes, again: bytes) -> None:
    """Over a few sockets, the same frames as fast as they are taken."""

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError, EOFError):
                writer = await watch(target)
                writer.write(first)
                for _ in range(2000):
                    writer.write(again)
                    await writer.drain()
                writer.close()
            await asyncio.sleep(0.01)

    await asyncio.gather(*(one() for _ in range(CONNECTIONS)))


def empty(opcode: int) -> bytes:
    """A masked frame without content."""
    return struct.pack(">BB4s", opcode, 0x80, b"\1\2\3\4")


async def pongs(target: Target) -> None:
    await send_frames(target, b"", empty(PONG) * 500)


async def fragments(target: Target) -> None:
    """A text that never ends, in empty pieces."""
    await send_frames(target, empty(PART), empty(CONTINUATION) * 500)


async def inputs(target: Target) -> None:
    frame = masked(BINARY, Input(0, 1, 0, 0, 1.0, 0.0, 0, 0, 0.0).encode())
    await send_frames(target, b"", frame * 200)


async def joins(target: Target) -> None:
    """Joins with as many wrong keys as a frame holds, one after the other."""
    keys = [""] * 1000

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError, EOFError):
                reader, writer = await join(target, {"tokens": keys})
                await reader.read(4096)
                writer.close()
            await asyncio.sleep(0)

    await asyncio.gather(*(one() for _ in range(CONNECTIONS)))


async def requests(target: Target) -> None:
    """The start page and a picture, over connections that are kept open where the server lets them."""

    async def one(path: str) -> None:
        request = f"GET {path} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\n\r\n".encode() * 20
        while True:
            with contextlib.suppress(OSError, EOFError):
                reader, writer = await connect(target)
                for _ in range(500):
                    writer.write(request)
                    await writer.drain()
                    if not await reader.read(1 << 20):
                        break
                writer.close()
            await asyncio.sleep(0)

    paths = ["/", f"/api/rooms/{target.room}/qr.svg"]
    await asyncio.gather(*(one(paths[number % 2]) for number in range(CONNECTIONS)))


async def connects(target: Target) -> None:
    """Connections that are made and dropped without a word."""

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError):
                _, writer = await connect(target)
                writer.transport.abort()
            await asyncio.sleep(0)

    await asyncio.gather(*(one() for _ in range(CONNECTIONS)))


async def rooms(target: Target) -> None:
    """Rooms that nobody joins."""
    body = json.dumps({"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]})
    head = f"POST /api/rooms HTTP/1.1\r\nHost: {target.host}:{target.port}\r\nContent-Length: {len(body)}\r\n\r\n"
    while True:
        with contextlib.suppress(OSError, EOFError):
            reader, writer = await connect(target)
            for _ in range(50):
                writer.write((head + body).encode())
                if not await reader.read(1 << 16):
                    break  # the server has ended the connection
            writer.close()
        await asyncio.sleep(0)


async def heads(target: Target) -> None:
    """Requests whose headers never end."""

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError):
                _, writer = await connect(target)
                writer.write(b"GET / HTTP/1.1\r\nHost: x\r\nX-Long: ")
                for _ in range(1000):
                    writer.write(b"z" * 65536)
                    await writer.drain()
            await asyncio.sleep(0)

    await asyncio.gather(*(one() for _ in range(4)))


async def origins(target: Target) -> None:
    """Websockets of foreign pages, each of which could leave a line in the log."""

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError, EOFError):
                reader, writer = await connect(target)
                writer.write(
                    f"GET /ws/{target.room} HTTP/1.1\r\nHost: {target.host}:{target.port}\r\nUpgrade: websocket\r\n"
                    "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                    "Sec-WebSocket-Version: 13\r\nOrigin: http://evil.example\r\n\r\n".encode()
                )
                await reader.read(4096)
                writer.close()
            await asyncio.sleep(0)

    await asyncio.gather(*(one() for _ in range(CONNECTIONS)))


FLOODS: dict[str, Callable[[Target], Awaitable[None]]] = {
    flood.__name__: flood for flood in (pongs, fragments, inputs, joins, requests, connects, rooms, heads, origins)
}


def main(arguments: list[str]) -> None:
    name, address, room = arguments
    parts = urlsplit(address)
    target = Target(parts.hostname or "127.0.0.1", parts.port or 80, room)
    with contextlib.suppress(TimeoutError, KeyboardInterrupt):
        asyncio.run(asyncio.wait_for(FLOODS[name](target), SECONDS))


if __name__ == "__main__":
    main(sys.argv[1:])
