"""What the tests of both protocols need: frames of a websocket, bytes of a socket, and the count of connections."""

import socket

from movingout.server.connection.connection_limits import ConnectionLimits
from tests.server.live import Live

NO_JOIN = b"\x81\x82" + bytes(4) + b"{}"  # a masked text frame
CLOSE_FRAME = b"\x88\x02"


def read_until(client: socket.socket, end: bytes) -> bytes:
    read = b""
    while end not in read:
        part = client.recv(10_000)
        assert part, read
        read += part
    return read


def counts(live: Live) -> ConnectionLimits:
    assert live.server is not None
    return live.server._connections
