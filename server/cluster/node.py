"""One node of a cluster: keeps its leases, takes over the rooms of nodes that are gone, and gives back free shards.

Once a second it tells the database that it is alive. Rooms are opened in its `home` shard; shards that it took over
stay until their last room is closed.
"""

import asyncio
import logging
import random
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Protocol

from movingout.maps import MovingOutError
from movingout.server.cluster.errors import DatabaseAway, NodeEnds, NodeRefused
from movingout.server.cluster.held_leases import HeldLeases
from movingout.server.cluster.joining import refuse_unfit
from movingout.server.cluster.lease_store import (
    FORGET_S,
    OPENING,
    ClusterView,
    LeaseRow,
    LeaseStore,
    NodeIdentity,
    NodeRow,
)
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.cluster.study_tries import StudyTries

log = logging.getLogger(__name__)

RENEW_S = 1.0
AGAIN_S = 0.25  # after a call that failed: three of them fit into a lease
LOOK_S = 60.0  # between two looks for rooms and recordings that no node has
SPARE = 8  # shards that are left to nodes that join
ROUTED_S = 2.5  # until the proxy knows where a shard is


def lease_clock() -> float:
    """Seconds of a clock that goes on while the machine sleeps."""
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))


class RoomKeeper(Protocol):
    """What a node has done with the rooms of its shards (server.cluster.host.ClusterHost)."""

    async def open_shard(self, shard: str, fence: int) -> None:
        """Go on with the rooms of a shard, as the last node left them. Raises ClusterError."""

    def close_shard(self, shard: str) -> None:
        """Let go of the rooms, at once and without a word to the disk."""

    def room_counts(self) -> dict[str, int]:
        """Rooms by shard."""

    def can_give_back(self, shard: str) -> bool:
        """Whether nothing is left of a shard: no room and no unfinished recording."""

    def forget_shard(self, shard: str, fence: int) -> None:
        """The shard was given back."""

    def can_see(self, shard: str) -> bool:
        """Whether the files of a shard lie in the data folder."""

    async def shards_on_disk(self) -> frozenset[str]:
        """Shards of which rooms or unfinished recordings lie in the data folder."""


class ClusterNode:
    """`open` has the shards whose rooms are here; those of `leases` besides are being opened.

    With `study`, one node of several runs it: it has the lease STUDY. All nodes of a study share a data folder.
    """

    def __init__(
        self, who: NodeIdentity, store: LeaseStore, rooms: RoomKeeper, clock: Callable[[], float] = lease_clock,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep, study: bool = False,
    ) -> None:  # fmt: skip
        self.who = who
        self.store = store
        self.leases = HeldLeases(store.lease_s)
        self.leases.shared = study  # its rooms wait for the database anyway
        self._study = study
        self.study_tries = StudyTries()
        self.open: set[str] = set()
        self.home = ""
        self.home_since = 0.0  # when the home shard was opened
        self.problem = ""  # why the database cannot be asked, empty while it can
        self.state = "serving"
        self.view = ClusterView((), ())
        self._rooms = rooms
        self._clock, self._sleep = clock, sleep
        self._opening: dict[str, asyncio.Task[None]] = {}
        self._left: frozenset[str] = frozenset()
        self._task: asyncio.Task[None] | None = None

    # ---- what others ask ------------------------------------------------------------------------------------

    def now(self) -> float:
        return self._clock()

    def serves(self, shard: str) -> bool:
        """Whether the rooms of a shard are here, and may go on at this moment."""
        return shard in self.open and self.leases.valid(shard, self._clock())

    @property
    def takes_rooms(self) -> bool:
        """Whether a new room would be found: the proxy has had time to learn where the home shard is."""
        return self.serves(self.home) and self._clock() - self.home_since > ROUTED_S

    def comes_back_soon(self, shard: str) -> bool | None:
        """Of a shard that is not here: whether another node goes on with its rooms; None when there are none."""
        lease = self.view.lease(shard)
        if lease is None or lease.node is None:
            return None
        if shard in self.leases or lease.expired_s < self.store.lease_s:
            return True
        return lease.shared and any(self._may_take(node, lease) for node in self.view.nodes)

    # ---- start and stop -------------------------------------------------------------------------------------

    async def join(self) -> None:
        """Become a node with a home shard. Raises NodeRefused and ClusterError with what would work."""
        await self.check()
        await self.look()  # before there are leases that could end meanwhile
        await self._register()
        self.leases.shared |= self._is_shared(self.view)
        await self._take_own()
        await self._take_left()
        if not self.home:
            await self._find_home()
        if not self.home:
            raise NodeRefused("all shards of the cluster are in use: end another node, or wait for rooms to close")

    def begin(self) -> None:
        self._task = asyncio.create_task(self._run(), name="the leases of this node")

    async def stop_opening(self, shard: str) -> None:
        """Give up opening a shard, or the study, where that has begun: `leave` waits for everything that is opened."""
        if (task := self._opening.get(shard)) is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    async def leave(self) -> None:
        """Hand the rooms over: everything about them is on the disk."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await asyncio.gather(*self._opening.values())
        try:
            await self.store.leave(self.who)
        except DatabaseAway as error:
            log.warning("%s; others take the rooms over when the lease ends", error)
        await self.store.close()

    async def check(self) -> None:
        """Raise ClusterError when this node could not join."""
        await self.store.prepare()
        self.view = await self.store.view()
        refuse_unfit(self.who, self.view, self._study)

    async def _register(self) -> None:
        deadline = self._clock() + 2 * self.store.lease_s
        while not await self.store.join(self.who):
            if self._clock() > deadline:
                known = self.view.node(self.who.name)
                where = f" at {known.address}" if known is not None and known.address else ""
                raise NodeRefused(f"a node {self.who.name} is running already{where}; give this one another name")
            await self._sleep(RENEW_S)

    async def _take_own(self) -> None:
        """The shards that the last run of this node left, as soon as its leases are over."""
        deadline = self._clock() + 2 * self.store.lease_s
        while self._clock() < deadline:
            self.view = await self.store.view()
            mine = [lease for lease in self.view.leases if lease.node == self.who.name and lease.run != self.who.run]
            mine = [lease for lease in mine if lease.folder == self.who.folder and lease.format == self.who.format]
            for lease in mine:
                if lease.expired_s >= 0.0:
                    await self._take(lease)
            if all(lease.expired_s >= 0.0 for lease in mine):
                return
            await self._sleep(RENEW_S / 4)

    async def _find_home(self) -> None:
        """Take a free shard for new rooms."""
        free = self._free()
        random.shuffle(free)
        for lease in free:
            if await self._take(lease):
                return

    async def look(self) -> frozenset[str]:
        """Which shards have something in the data folder; the next step takes those that are free.

        Not in a step: the disk may hang for longer than a lease.
        """
        self._left = await self._rooms.shards_on_disk()
        return self._left

    async def _take_left(self) -> None:
        """Free shards of which the data folder has something: a server that was no node or another database left it."""
        if self.state != "serving":
            return
        on_disk, free = self._left, self._free()
        self._left = frozenset()
        for lease in [lease for lease in free if lease.shard in on_disk][: max(0, len(free) - SPARE)]:
            if await self._take(lease):
                log.warning("took the shard %r: no node had its rooms or recordings in the data folder", lease.shard)

    def _free(self) -> list[LeaseRow]:
        """Leases that nobody has or waits for."""
        return [
            lease
            for lease in self.view.leases
            if lease.shard in SHARDS and (lease.node is None or lease.expired_s > FORGET_S)
        ]

    async def _take(self, lease: LeaseRow) -> bool:
        asked_at = self._clock()
        fence = await self.store.take(self.who, lease, self.leases.shared)
        if fence is None:
            return False
        self.leases.taken(lease.shard, fence, asked_at)
        if lease.shard in SHARDS:
            self.home = self.home or lease.shard
        return True

    # ---- once a second --------------------------------------------------------------------------------------

    async def _run(self) -> None:
        while True:
            pause_s = RENEW_S
            try:
                await self.step()
            except DatabaseAway as error:
                self._say(str(error))
                pause_s = AGAIN_S
            except Exception as error:  # the leases must go on being renewed
                log.exception("the leases of this node: %s", error)
            self._close_lapsed()
            await self._sleep(pause_s)

    async def step(self) -> None:
        """Renew, look, take over, give back. Raises DatabaseAway."""
        asked_at = self._clock()
        kept, self.view = await self.store.renew(
            who=self.who,
            held=self.leases.fences,
            rooms=self._rooms.room_counts(),
            shared=self.leases.shared,
            state=self.state,
            problem=self._why_no_study(),
        )
        self._say("")
        for shard in self.leases.renewed(kept, asked_at):
            log.error("the lease of %s is lost: another node goes on with it", _named(shard))
            self._close(shard)
        self.leases.shared |= self._is_shared(self.view)
        for lease in self._to_take_over():
            if await self._take(lease):
                log.warning("took over the shard %r of node %s with %d rooms", lease.shard, lease.node, lease.rooms)
        await self._take_left()
        if not self.home and self.state == "serving":
            await self._find_home()
        await self._pass_study_on()
        await self._take_study()
        for shard in self.leases:
            if shard not in self.open and shard not in self._opening:
                self._open(shard)
        await self._give_back()

    async def _take_study(self) -> None:
        """Of several nodes that try, one gets it."""
        lease = self.view.lease(STUDY)
        if not self._study or lease is None or STUDY in self.leases:
            return
        if lease.node is not None and lease.expired_s <= 0.0:
            other = self.view.node(lease.node)
            if other is not None and not other.problem:
                self.study_tries.went_well()
        elif self.state == "serving" and self.study_tries.may_try(self._clock()) and await self._take(lease):
            log.warning("this node runs the study now (fencing token %d)", self.leases.fence(STUDY))

    async def _pass_study_on(self) -> None:
        """What has failed here several times, another node may do; this one, if there is none, or after a pause."""
        failed = STUDY in self.leases and STUDY not in self._opening and self.study_tries.used_up
        lease = self.view.lease(STUDY)
        if failed and lease is not None and any(self._may_take(node, lease) for node in self.view.nodes):
            log.error("%s; another node may try now", self.study_tries.problem)
            fence = self.leases.fence(STUDY)
            self.leases.dropped(STUDY)
            self.study_tries.given_back(self._clock())
            await self.store.release(self.who, STUDY, fence)
            self.view = await self.store.view()

    def _why_no_study(self) -> str:
        """Told to the others, so that nobody believes that the study is served here before it is."""
        opening = STUDY in self.leases and STUDY not in self.open
        return self.study_tries.problem or (OPENING if opening else "")

    def _to_take_over(self) -> Iterator[LeaseRow]:
        """This node's part of the shards that are to be taken over: every node alive comes to the same division.

        What an earlier run of a node had goes to that node, also when its lease was longer than the node waited.
        """
        expired = [each for each in self.view.leases if each.node is not None and each.expired_s > 0]
        for position, lease in enumerate(lease for lease in expired if lease.shard in SHARDS):
            able = [node.name for node in self.view.nodes if self._may_take(node, lease)]
            if lease.node == self.who.name and lease.node in able:
                yield lease
            elif self.who.name in able and lease.node not in able and able[position % len(able)] == self.who.name:
                if self._rooms.can_see(lease.shard):
                    yield lease
                else:
                    log.warning("the rooms of the shard %r are not in the data folder", lease.shard)

    def _may_take(self, node: NodeRow, lease: LeaseRow) -> bool:
        """Whether a node may go on with an expired lease; the run that let it expire renews it or has lost it."""
        return (
            (lease.shared or lease.node == node.name)
            and node.run != lease.run
            and node.alive
            and node.state == "serving"
            and (node.folder, node.format) == (lease.folder, lease.format)
        )

    def _is_shared(self, view: ClusterView) -> bool:
        return any(node.folder == self.who.folder and node.name != self.who.name for node in view.nodes)

    def _open(self, shard: str) -> None:
        task = asyncio.create_task(self._open_now(shard, self.leases.fence(shard)), name=f"shard {shard}")
        self._opening[shard] = task
        task.add_done_callback(lambda _: self._opening.pop(shard, None))

    async def _open_now(self, shard: str, fence: int) -> None:
        try:
            await self._rooms.open_shard(shard, fence)
        except NodeEnds:
            return
        except MovingOutError as error:
            problem = str(error)
            log.error("%s cannot be opened: %s", _named(shard), error)
        except Exception as error:  # tried again in a second
            problem = f"{type(error).__name__}: {error}"
            log.exception("%s cannot be opened: %s", _named(shard), error)
        else:
            self.open.add(shard)
            self.home_since = self._clock() if shard == self.home else self.home_since
            if shard == STUDY:
                self.study_tries.went_well()
            return
        self._rooms.close_shard(shard)
        if shard == STUDY and self.leases.valid(STUDY, self._clock()):
            self.study_tries.failed(problem)

    async def opened(self) -> None:
        """Wait until the rooms of all shards are there; a study waits for those of other nodes, too."""
        for shard in self.leases:
            if shard not in self.open and shard not in self._opening:
                self._open(shard)
        await asyncio.gather(*(task for shard, task in self._opening.items() if shard != STUDY))

    async def _give_back(self) -> None:
        for shard in self.open - {self.home, STUDY}:
            if self._rooms.can_give_back(shard):
                fence = self.leases.fence(shard)
                self.leases.dropped(shard)
                self.open.discard(shard)
                await self.store.release(self.who, shard, fence)
                self._rooms.forget_shard(shard, fence)

    def _close_lapsed(self) -> None:
        """Rooms whose lease is over wait on the disk; they are opened again when the database says they are ours."""
        lapsed = [shard for shard in self.open if not self.leases.valid(shard, self._clock())]
        for shard in lapsed:
            log.error("the lease of %s is over: it waits", _named(shard))
            self._close(shard)

    def _close(self, shard: str) -> None:
        self.open.discard(shard)
        if shard == self.home and shard not in self.leases:
            self.home = ""
        self._rooms.close_shard(shard)

    def _say(self, problem: str) -> None:
        if problem and not self.problem:
            log.error(
                "%s; rounds go on for %.0f s at most where another node has the folder too", problem, self.store.lease_s
            )
        elif self.problem and not problem:
            log.warning("the database answers again")
        self.problem = problem


def _named(shard: str) -> str:
    """What to call a lease in a sentence."""
    return "the study" if shard == STUDY else f"the shard {shard!r}"
