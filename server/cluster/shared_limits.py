"""Limits of an address that hold for all nodes together. While the database is away, those of this node hold alone."""

import asyncio
import hashlib
import logging
import time
from collections import Counter
from collections.abc import Callable, Coroutine, Mapping
from typing import Any, TypeVar

from movingout.server.cluster.errors import DatabaseAway
from movingout.server.cluster.limit_store import RECORDED, LimitStore, Rate
from movingout.server.connection.admission import DAY_S, ROUND_BYTES
from movingout.server.connection.other_nodes import OtherNodes, RoomCount
from movingout.server.settings import Limits

log = logging.getLogger(__name__)

SHARE_S = 1.0  # until the other nodes know that a room was joined or closed, or what it has recorded
PRUNE_S = 60.0
NO_ROOMS = RoomCount()

Answer = TypeVar("Answer")


class SharedLimits(OtherNodes):
    """`rooms` counts those of this node by owner (`admission.owner`). Repeat `share`, every SHARE_S, after `begin`.

    Openings and wrong tokens ask the database. It is told of everything else once in a while, and only of changes.
    """

    def __init__(
        self, run: str, store: LimitStore, limits: Limits, rooms: Callable[[], Mapping[str, RoomCount]],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._run, self._store, self._rooms, self._clock = run, store, rooms, clock
        self._openings = _a_minute(limits.rooms_per_address_per_minute)
        self._guesses = _a_minute(limits.wrong_tokens_per_minute)
        self._bytes = Rate(limits.recorded_per_address_per_day / DAY_S, limits.recorded_per_address_per_day)
        self.secret = ""  # of all nodes together
        self._away = True  # until `begin`
        self._published: dict[str, RoomCount] = {}
        self._unsure: set[str] = set()  # owners of whom the database may know something else than was published
        self._recorded: Counter[str] = Counter()
        self._pruned_at = clock()
        self._one_at_a_time = asyncio.Lock()

    def begin(self, secret: str) -> None:
        """Once the node has joined the cluster, whose secret names owners."""
        self.secret = secret
        self._away = False

    async def close(self) -> None:
        await self._store.close()

    # ---- questions ------------------------------------------------------------------------------------------

    async def may_record(self, owner: str) -> bool:
        return await self._ask(self._store.has(RECORDED, self._name(owner), self._bytes, ROUND_BYTES), True)

    async def may_open_room(self, owner: str) -> RoomCount | None:
        return await self._ask(self._may_open_room(owner), NO_ROOMS)

    async def _may_open_room(self, owner: str) -> RoomCount | None:
        self._unsure.add(owner)
        here = self._rooms().get(owner, NO_ROOMS)
        here = RoomCount(here.open + 1, here.unjoined + 1)
        return await self._store.open_room(self._run, self._name(owner), here, self._openings)

    async def may_guess(self, group: str, secret: str) -> bool:
        return await self._ask(self._store.take(f"wrong {secret}", self._name(group), self._guesses), True)

    def recorded(self, owner: str, size: int) -> None:
        self._recorded[owner] += size

    async def _ask(self, question: Coroutine[Any, Any, Answer], otherwise: Answer) -> Answer:
        """The answer of the database, or what holds while it is away; then only the first one waits in vain."""
        async with self._one_at_a_time:
            if self._away:
                question.close()
                return otherwise
            try:
                return await question
            except DatabaseAway as error:
                self._lost(error)
                return otherwise

    # ---- once a second --------------------------------------------------------------------------------------

    async def share(self) -> None:
        """Tell the database what has changed here; while it is away, this finds out when it is back."""
        async with self._one_at_a_time:
            try:
                await self._share()
            except DatabaseAway as error:
                self._lost(error)
            else:
                self._found()

    async def _share(self) -> None:
        rooms = self._rooms()
        owners = {*rooms, *self._published, *self._unsure}
        changed = {owner: rooms.get(owner, NO_ROOMS) for owner in owners}
        changed = {who: n for who, n in changed.items() if who in self._unsure or n != self._published.get(who)}
        if changed or self._recorded or self._away:
            await self._publish(changed)
        if self._clock() - self._pruned_at >= PRUNE_S:
            self._pruned_at = self._clock()
            await self._store.prune()

    async def _publish(self, rooms: Mapping[str, RoomCount]) -> None:
        recorded, self._recorded = self._recorded, Counter()
        self._unsure |= set(rooms)
        try:
            await self._store.publish(
                self._run,
                {self._name(owner): count for owner, count in rooms.items()},
                {self._name(owner): size for owner, size in recorded.items()},
                self._bytes,
            )
        except DatabaseAway:
            self._recorded += recorded
            raise
        self._unsure.clear()
        for owner, count in rooms.items():
            self._published.pop(owner, None)
            if count.open:
                self._published[owner] = count

    # ---- the database ---------------------------------------------------------------------------------------

    def _name(self, who: str) -> str:
        """What the database calls an owner or an address: whoever reads a row does not see whose it is."""
        return hashlib.blake2b(who.encode(), key=self.secret.encode()[:64], digest_size=16).hexdigest()

    def _lost(self, error: DatabaseAway) -> None:
        if not self._away:
            log.warning("%s; until it does, limits of addresses hold at each node alone", error)
        self._away = True

    def _found(self) -> None:
        if self._away:
            log.warning("limits of addresses hold for all nodes together again")
        self._away = False


def _a_minute(count: int) -> Rate:
    return Rate(count / 60.0, count)
