"""Limits on what one address, and all together, may use of this server."""

from collections import defaultdict
from collections.abc import Callable
from typing import Literal, TypeVar

from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.settings import Limits

FORGET_AFTER = 10_000  # addresses; then all are cleared
LOCK_S = 60.0
FLOODS_PER_MINUTE = 10
BAN_S = 10.0
PICTURES_PER_MINUTE = 12

Secret = Literal["seat", "admin"]
Key = TypeVar("Key")


class AdmissionControl:
    """Counts sockets and wrong tokens per address. A refusal is a sentence; empty means admitted."""

    def __init__(self, limits: Limits, clock: Callable[[], float]) -> None:
        self._limits = limits
        self._clock = clock
        self._sockets: defaultdict[str, int] = defaultdict(int)
        self._waiting: defaultdict[str, int] = defaultdict(int)
        self._guesses: dict[tuple[str, Secret], TokenBucket] = {}
        self._openings: dict[str, TokenBucket] = {}
        self._floods: dict[str, TokenBucket] = {}
        self._drawings: dict[str, TokenBucket] = {}
        self._banned: dict[str, float] = {}  # until
        self._locked: dict[tuple[str, Secret], float] = {}  # until

    @property
    def sockets(self) -> int:
        return sum(self._sockets.values())

    def enter(self, address: str) -> str:
        """Admit a socket, or return why not; an admitted one must `leave`."""
        limits = self._limits
        if self._clock() < self._banned.get(address, 0.0):
            return "Connections from your address have flooded this server; wait a few seconds."
        if self.sockets >= limits.sockets:
            return "The server is full; try again in a minute."
        if self._sockets[address] >= limits.sockets_per_address:
            return f"There are {limits.sockets_per_address} connections from your address already; close some of them."
        if self._waiting[address] >= limits.waiting_per_address:
            return "Too many connections from your address have not joined a room yet; try again in a few seconds."
        self._sockets[address] += 1
        self._waiting[address] += 1
        return ""

    def joined(self, address: str) -> None:
        """The socket has joined a room or stopped waiting."""
        _count_down(self._waiting, address)

    def leave(self, address: str) -> None:
        _count_down(self._sockets, address)

    def flooded(self, address: str) -> bool:
        """A socket was cut off for flooding; True for the first of a series, which is worth logging.

        An address that keeps flooding is banned for a while; its running games continue.
        """
        strikes = self._bucket(self._floods, address, FLOODS_PER_MINUTE)
        first = strikes.full(self._clock())
        if not strikes.take(self._clock()):
            self._banned[address] = self._clock() + BAN_S
        return first

    def locked(self, address: str, secret: Secret) -> bool:
        """Whether this address is locked after too many wrong tokens. Guessing seats does not lock the admin out."""
        return self._clock() < self._locked.get((address, secret), 0.0)

    def wrong_token(self, address: str, secret: Secret) -> None:
        """Count a wrong token; too many per minute lock the address."""
        per_minute = self._limits.wrong_tokens_per_minute
        if not self._bucket(self._guesses, (address, secret), per_minute).take(self._clock()):
            self._locked[address, secret] = self._clock() + LOCK_S

    def may_open_room(self, address: str) -> bool:
        per_minute = self._limits.rooms_per_address_per_minute
        return self._bucket(self._openings, address, per_minute).take(self._clock())

    def may_draw(self, address: str) -> bool:
        """Whether a picture of a round may be drawn for this address now."""
        return self._bucket(self._drawings, address, PICTURES_PER_MINUTE).take(self._clock())

    def _bucket(self, buckets: dict[Key, TokenBucket], key: Key, per_minute: int) -> TokenBucket:
        if len(buckets) > FORGET_AFTER:
            buckets.clear()
            self._locked.clear()
            self._banned.clear()
        if key not in buckets:
            buckets[key] = TokenBucket(per_minute / 60.0, per_minute, self._clock())
        return buckets[key]


def _count_down(counts: defaultdict[str, int], address: str) -> None:
    counts[address] -= 1
    if counts[address] <= 0:
        del counts[address]
