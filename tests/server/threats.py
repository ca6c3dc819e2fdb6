"""What the tests of the threat table share."""

import time

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from tests.server.live import Live, Person


def close_code(connection: ClientConnection, seconds: float = 10.0) -> int:
    """Read until the end: the close code, 1006 for none."""
    deadline = time.monotonic() + seconds
    try:
        while time.monotonic() < deadline:
            connection.recv(max(0.01, deadline - time.monotonic()))
    except ConnectionClosed as closed:
        return closed.rcvd.code if closed.rcvd else 1006
    except TimeoutError:
        pass
    raise AssertionError("the connection stays open")


def player(live: Live) -> Person:
    room = live.open_room("here", "idle")
    return live.person(room["room"], tokens=[room["tokens"][0]])
