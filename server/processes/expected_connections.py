"""In which process the next connections from an address are expected: of TLS, where a server cannot look first."""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from movingout.server.connection.admission import keep
from movingout.server.processes.room_link import RoomLink

EXPECTED_S = 2.0
CONNECTIONS = 3  # until its websocket has arrived
MOST_EXPECTED = 50  # connections of one address


@dataclass(eq=False)
class _Expectation:
    link: RoomLink
    until: float
    left: int = CONNECTIONS


class ExpectedConnections:
    """Which process the next connections from an address are for, until its websocket has arrived there.

    A browser that does not trust the certificate of itself breaks off its first connection and makes a second one.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._by_address: dict[str, deque[_Expectation]] = {}

    def add(self, address: str, link: RoomLink) -> None:
        if address not in self._by_address:
            keep(self._by_address, address, deque(maxlen=MOST_EXPECTED))
        self._by_address[address].append(_Expectation(link, self._clock() + EXPECTED_S))

    def take(self, address: str) -> RoomLink | None:
        """Where a connection from this address goes; None for here."""
        while expected := self._by_address.get(address):
            first = expected[0]
            first.left -= 1
            if first.left <= 0 or self._clock() >= first.until:
                self._remove(address, first)
            if self._clock() < first.until:
                return first.link
        return None

    def arrived(self, address: str, link: RoomLink) -> None:
        """A websocket from this address has reached the process."""
        for each in self._by_address.get(address, ()):
            if each.link is link:
                self._remove(address, each)
                return

    def _remove(self, address: str, one: _Expectation) -> None:
        expected = self._by_address[address]
        expected.remove(one)
        if not expected:
            del self._by_address[address]
