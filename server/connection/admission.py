"""Limits on what one address, and all together, may use of this server."""

import ipaddress
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Literal, TypeVar

from movingout.server.connection.networks import TIMES, counted_as, take_from_all
from movingout.server.connection.other_nodes import OtherNodes
from movingout.server.connection.socket_counts import SocketCounts
from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.security.tokens import new_token, pseudonym
from movingout.server.settings import Limits

MOST_KEPT = 10_000  # addresses; then who came longest ago is forgotten
LOCK_S = 60.0
FLOODS_PER_MINUTE = 10
BAN_S = 10.0
PICTURES_PER_MINUTE = 12
MAP_WORK_S = 20.0  # of a process in a minute
REPLAYS_PER_MINUTE = 60
DAY_S = 86_400.0
ROUND_BYTES = 100_000  # a short one
LEAST_BYTES = 65_536  # that a recording counts: a file takes more of a disk than its bytes

Secret = Literal["seat", "admin"]
SocketNews = Literal["entered", "joined", "left", "flooded"]
Key = TypeVar("Key")
Kept = TypeVar("Kept")


class AdmissionControl:
    """Counts sockets and wrong tokens per address. A refusal is a sentence; empty means admitted.

    `elsewhere` counts the sockets of other processes, where there are some; `on_socket` is told of those here. `secret`
    makes the names under which addresses own rooms, which are kept on the disk: the same one, the same names.
    `other_nodes` says what an address has used of its limits at other nodes of a cluster.
    """

    def __init__(
        self,
        limits: Limits,
        clock: Callable[[], float],
        elsewhere: Callable[[], Iterable[SocketCounts]] = tuple,
        secret: str = "",
    ) -> None:
        self._limits = limits
        self._clock = clock
        self._here = SocketCounts()
        self._elsewhere = elsewhere
        self._secret = secret or new_token()
        self.on_socket: Callable[[SocketNews, str], None] = lambda news, address: None
        self.other_nodes = OtherNodes()
        self._guesses: dict[Secret, dict[str, TokenBucket]] = {"seat": {}, "admin": {}}
        self._openings: dict[str, TokenBucket] = {}
        self._checks: dict[str, TokenBucket] = {}
        self._solves: dict[str, TokenBucket] = {}
        self._floods: dict[str, TokenBucket] = {}
        self._replays: dict[str, TokenBucket] = {}
        self._drawings: dict[str, TokenBucket] = {}
        self._study_arrivals: dict[str, TokenBucket] = {}
        self._study_consents: dict[str, TokenBucket] = {}
        self._study_changes: dict[str, TokenBucket] = {}  # by participant
        self._study_answers: dict[str, TokenBucket] = {}  # by participant
        self._unknown_tokens: dict[str, TokenBucket] = {}
        self._requests: dict[str, TokenBucket] = {}
        self._being_answered: Counter[str] = Counter()  # requests by address
        self._answered: dict[str, TokenBucket] = {}  # bytes of answers that may still be kept
        self._recorded: dict[str, TokenBucket] = {}  # bytes that may still be recorded, by owner
        self.refusals: Counter[str] = Counter()  # by reason
        self._banned: dict[str, float] = {}  # until
        self._arrivals: dict[str, TokenBucket] = {}
        self._room_owners: dict[str, str] = {}  # owner by room
        self._rooms_of: dict[str, set[str]] = {}  # open ones by owner
        self._being_opened: Counter[str] = Counter()  # by owner
        self._locked: dict[tuple[str, Secret], float] = {}  # until

    @property
    def sockets(self) -> int:
        """Of this process."""
        return self._here.total

    def enter(self, address: str) -> str:
        """Admit a socket, or return why not; an admitted one must be `joined` and `leave`."""
        refusal = self.try_socket(address)
        if not refusal:
            self._here.entered(address_group(address))
            self.on_socket("entered", address)
        return refusal

    def try_socket(self, address: str) -> str:
        """Why one more socket from here may not enter now; one that may can enter here or in another process."""
        limits, address = self._limits, address_group(address)
        counts = (self._here, *self._elsewhere())
        if self._clock() < self._banned.get(address, 0.0):
            return "Connections from your address have flooded this server; wait a few seconds."
        if sum(each.total for each in counts) >= limits.sockets:
            return "The server is full; try again in a minute."
        for group, times in counted_as(address):
            most = times * limits.sockets_per_address
            if sum(each.open.get(group, 0) for each in counts) >= most:
                return f"There are {most} connections from your address already; close some of them."
            if sum(each.waiting.get(group, 0) for each in counts) >= times * limits.waiting_per_address:
                return "Too many connections from your address have not joined a room yet; try again in a few seconds."
        if not self._take_in_minute(self._arrivals, address, limits.connects_per_address_per_minute):
            return "Too many connections were made from your address in the last minute; wait a few seconds."
        return ""

    def joined(self, address: str) -> None:
        """The socket has joined a room or stopped waiting."""
        self._here.joined(address_group(address))
        self.on_socket("joined", address)

    def leave(self, address: str) -> None:
        self._here.left(address_group(address))
        self.on_socket("left", address)

    def flooded(self, address: str) -> bool:
        """A socket was cut off for flooding; True for the first of a series, which is worth logging.

        An address that keeps flooding is banned for a while; its running games continue.
        """
        self.refusals["flood"] += 1
        self.on_socket("flooded", address)
        return self.strike(address)

    def strike(self, address: str) -> bool:
        """The same for a socket of another process, which counts the refusal."""
        address = address_group(address)
        now = self._clock()
        strikes = used(self._floods, address, FLOODS_PER_MINUTE / 60.0, FLOODS_PER_MINUTE, now)
        first = strikes.full(now)
        if not strikes.take(now):
            keep(self._banned, address, now + BAN_S)
        return first

    async def guesses_too_often(self, address: str, secret: Secret) -> bool:
        """Count a wrong token; True once there are too many per minute, which is all that the guesser then hears.

        A right one is never counted and never refused: whoever shares the address plays on, and tokens of 128 bits, or
        codes of 40, are not guessed at this rate.
        """
        key, now = (address_group(address), secret), self._clock()
        if now < self._locked.get(key, 0.0):
            return True
        few = self._take_in_minute(self._guesses[secret], key[0], self._limits.wrong_tokens_per_minute)
        if few and await self.other_nodes.may_guess(*key):
            return False
        keep(self._locked, key, now + LOCK_S)
        return True

    def may_request(self, address: str, cost: float) -> bool:
        """Whether an HTTP request may be answered for this address now; refusals are counted."""
        per_s = self._limits.requests_per_address_per_s
        allowed = self._take(self._requests, address_group(address), per_s, 30.0 * per_s, cost)
        self.refusals["requests"] += not allowed
        return allowed

    def begin_answer(self, address: str) -> bool:
        """Whether one more request of this address may be answered at the same time; it counts until `end_answer`.

        Connections are limited already, but those of a trusted proxy.
        """
        counted, most = counted_as(address_group(address)), self._limits.connections_per_address
        allowed = all(self._being_answered[group] < times * most for group, times in counted)
        if allowed:
            self._being_answered.update(group for group, _ in counted)
        self.refusals["requests"] += not allowed
        return allowed

    def end_answer(self, address: str) -> None:
        for group, _ in counted_as(address_group(address)):
            self._being_answered[group] -= 1
            if not self._being_answered[group]:
                del self._being_answered[group]

    def recorded(self, room_id: str, size: int) -> None:
        """A room has recorded a round of so many bytes."""
        owner, size = self._room_owners.get(room_id), max(size, LEAST_BYTES)
        if owner is None:
            return
        now, per_day = self._clock(), self._limits.recorded_per_address_per_day
        for name, times in recorded_as(owner):
            left = used(self._recorded, name, times * per_day / DAY_S, times * per_day, now)
            if not left.take(now, size):
                left.empty(now)
        self.other_nodes.recorded(owner, size)

    def may_record(self, address: str) -> bool:
        """Whether rooms of this address may fill the disk further today."""
        now, buckets = self._clock(), [self._recorded.get(name) for name, _ in recorded_as(self.owner(address))]
        return all(bucket is None or bucket.holds(now, ROUND_BYTES) for bucket in buckets)

    def may_answer(self, address: str, size: int) -> bool:
        """Whether answers of so many bytes may be kept for this address now: they stay on the disk."""
        per_day = self._limits.answered_per_address_per_day
        return self._take(self._answered, address_group(address), per_day / DAY_S, per_day, size)

    def opening_began(self, address: str) -> None:
        """Until `opening_ended`, a room that is being opened counts as one that nobody has joined."""
        self._being_opened[self.owner(address)] += 1

    def opening_ended(self, address: str) -> None:
        self._being_opened -= Counter([self.owner(address)])  # which keeps no zeros

    def being_opened(self, address: str) -> int:
        return self._being_opened[self.owner(address)]

    def rooms_by_owner(self) -> dict[str, tuple[int, frozenset[str]]]:
        """For each owner, the rooms that are being opened and those that are open."""
        owners = {*self._being_opened, *self._rooms_of}
        return {owner: (self._being_opened[owner], frozenset(self._rooms_of.get(owner, ()))) for owner in owners}

    def may_open_room(self, address: str) -> bool:
        per_minute = self._limits.rooms_per_address_per_minute
        return self._take_in_minute(self._openings, address_group(address), per_minute)

    def name_owners_by(self, secret: str) -> None:
        """Nodes that share a secret know each other's owners; call it before there are rooms."""
        self._secret = secret

    def owner(self, address: str) -> str:
        """The name under which the rooms of an address are counted; for IPv6 it ends with that of its /48 network."""
        return ".".join(pseudonym(group, self._secret) for group, _ in counted_as(address_group(address)))

    def rooms_of(self, address: str) -> frozenset[str]:
        """The open rooms that were opened from here."""
        return self.rooms_owned_by(self.owner(address))

    def owner_of(self, room_id: str) -> str:
        """The owner of a room; empty if it was opened for nobody."""
        return self._room_owners.get(room_id, "")

    def rooms_owned_by(self, owner: str) -> frozenset[str]:
        """The open rooms of an owner."""
        return frozenset(self._rooms_of.get(owner, ()))

    def opened_room(self, owner: str, room_id: str) -> None:
        """A room was opened for this owner, or is there again; report its end to `closed_room`."""
        if owner:
            self._room_owners[room_id] = owner
            self._rooms_of.setdefault(owner, set()).add(room_id)

    def closed_room(self, room_id: str) -> None:
        owner = self._room_owners.pop(room_id, None)
        if owner is not None:
            self._rooms_of[owner].discard(room_id)
            if not self._rooms_of[owner]:
                del self._rooms_of[owner]

    def may_draw(self, address: str) -> bool:
        """Whether a picture of a round may be drawn for this address now."""
        return self._take_in_minute(self._drawings, address_group(address), PICTURES_PER_MINUTE)

    def may_replay(self, address: str) -> bool:
        """Whether a recording may be read for this address now."""
        return self._take_in_minute(self._replays, address_group(address), REPLAYS_PER_MINUTE)

    def may_arrive(self, address: str) -> bool:
        """Whether one more participant of a study may open a link here now."""
        per_minute = self._limits.study_arrivals_per_minute
        return self._take_in_minute(self._study_arrivals, address_group(address), per_minute)

    def may_consent(self, address: str) -> bool:
        """Whether one more participant of a study may begin here now: something is kept of each of them for good."""
        per_day = self._limits.study_consents_per_day
        return self._take(self._study_consents, address_group(address), per_day / DAY_S, per_day)

    def may_change(self, pid: str) -> bool:
        """Whether this participant of a study may ask for one more change now: changes wait for one another."""
        return self._take_of(self._study_changes, pid, self._limits.study_changes_per_s)

    def may_save_answer(self, pid: str) -> bool:
        """Whether this participant of a study may have one more answer written now."""
        return self._take_of(self._study_answers, pid, self._limits.study_answers_per_s)

    def _take_of(self, buckets: dict[str, TokenBucket], pid: str, per_s: float) -> bool:
        now = self._clock()
        return used(buckets, pid, per_s, 10.0 * per_s, now).take(now)

    def may_try_token(self, address: str) -> bool:
        """Whether a participant's token that is not in memory may be looked up for this address now."""
        per_s = self._limits.study_unknown_tokens_per_s
        return self._take(self._unknown_tokens, address_group(address), per_s, 100.0 * per_s)

    def may_check_map(self, address: str) -> bool:
        return self._take_in_minute(self._checks, address_group(address), self._limits.map_checks_per_minute)

    def worked_on_map(self, address: str, seconds: float) -> None:
        """A process has worked so long on a map for this address: MAP_WORK_S of that are all the checks of a minute."""
        per_minute, now = self._limits.map_checks_per_minute, self._clock()
        for group, times in counted_as(address_group(address)):
            checks = used(self._checks, group, times * per_minute / 60.0, times * per_minute, now)
            if not checks.take(now, seconds / MAP_WORK_S * per_minute):
                checks.empty(now)

    def may_solve_map(self, address: str) -> bool:
        return self._take_in_minute(self._solves, address_group(address), self._limits.map_solves_per_minute)

    def _take_in_minute(self, buckets: dict[str, TokenBucket], group: str, per_minute: int) -> bool:
        return self._take(buckets, group, per_minute / 60.0, per_minute)

    def _take(self, buckets: dict[str, TokenBucket], group: str, per_s: float, burst: float, cost: float = 1.0) -> bool:
        now = self._clock()
        return take_from_all(
            group, cost, now, lambda each, times: used(buckets, each, times * per_s, times * burst, now)
        )


def recorded_as(owner: str) -> list[tuple[str, int]]:
    """What the recordings of an owner count for, and how many times a day's limit each has, as in `counted_as`."""
    network = owner.partition(".")[2]
    return [(owner, 1), (network, TIMES)] if network else [(owner, 1)]


def address_group(address: str) -> str:
    """Whom a limit applies to: an IPv4 address, or the /64 network of an IPv6 one, which one person has whole."""
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv4Address):
        return address
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return str(ipaddress.IPv6Network((parsed, 64), strict=False))


def keep(kept: dict[Key, Kept], key: Key, value: Kept) -> None:
    """Set a value as the newest of at most MOST_KEPT."""
    kept.pop(key, None)
    kept[key] = value
    if len(kept) > MOST_KEPT:
        del kept[next(iter(kept))]


def used(buckets: dict[Key, TokenBucket], key: Key, per_s: float, burst: float, now: float) -> TokenBucket:
    """The bucket of a key, marked as the most recently used; a full one if there was none."""
    bucket = buckets.get(key) or TokenBucket(per_s, burst, now)
    keep(buckets, key, bucket)
    return bucket
