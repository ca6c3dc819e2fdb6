"""One node of a cluster: keeps its leases, takes over the rooms of nodes that are gone, and gives back free shards.

Once a second it tells the database that it is alive. Rooms are opened in its `home` shard; shards that it took over
stay until their last room is closed.
"""

import asyncio
import logging
import random
import time
from collections.abc import Awaitable, Callable

from movingout.server.cluster.errors import DatabaseAway, NodeRefused
from movingout.server.cluster.held_leases import HeldLeases
from movingout.server.cluster.joining import refuse_unfit
from movingout.server.cluster.lease_division import (
    free_leases,
    left_by_last_run,
    shares_folder,
    somebody_may_take,
    to_take_over,
)
from movingout.server.cluster.lease_store import OPENING, ClusterView, LeaseRow, LeaseStore, NodeIdentity
from movingout.server.cluster.open_shards import OpenShards, RoomKeeper
from movingout.server.cluster.shards import SHARDS, STUDY, lease_title
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


class ClusterNode:
    """`open_shards` has the shards whose rooms are here; those of `leases` besides are being opened.

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
        self.open_shards = OpenShards(rooms, self.leases, self.study_tries, clock)
        self.home = ""
        self.problem = ""  # why the database cannot be asked, empty while it can
        self.state = "serving"
        self.view = ClusterView((), ())
        self._rooms = rooms
        self._clock, self._sleep = clock, sleep
        self._left: frozenset[str] = frozenset()
        self._task: asyncio.Task[None] | None = None

    # ---- what others ask ------------------------------------------------------------------------------------

    def now(self) -> float:
        return self._clock()

    def serves(self, shard: str) -> bool:
        """Whether the rooms of a shard are here, and may go on at this moment."""
        return shard in self.open_shards and self.leases.valid(shard, self._clock())

    @property
    def takes_rooms(self) -> bool:
        """Whether a new room would be found: the proxy has had time to learn where the home shard is."""
        return self.serves(self.home) and self._clock() - self.open_shards.since(self.home) > ROUTED_S

    def comes_back_soon(self, shard: str) -> bool | None:
        """Of a shard that is not here: whether another node goes on with its rooms; None when there are none."""
        lease = self.view.lease(shard)
        if lease is None or lease.node is None:
            return None
        if shard in self.leases or lease.expired_s < self.store.lease_s:
            return True
        return lease.shared and somebody_may_take(self.view, lease)

    # ---- start and stop -------------------------------------------------------------------------------------

    async def join(self) -> None:
        """Become a node with a home shard. Raises NodeRefused and ClusterError with what would work."""
        await self.check()
        await self.look()  # before there are leases that could end meanwhile
        await self._register()
        self.leases.shared |= shares_folder(self.who, self.view)
        await self._take_own()
        await self._take_left()
        if not self.home:
            await self._find_home()
        if not self.home:
            raise NodeRefused("all shards of the cluster are in use: end another node, or wait for rooms to close")

    def begin(self) -> None:
        self._task = asyncio.create_task(self._run(), name="the leases of this node")

    async def leave(self) -> None:
        """Hand the rooms over: everything about them is on the disk."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self.open_shards.settled()
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
            mine = left_by_last_run(self.who, self.view)
            for lease in mine:
                if lease.expired_s >= 0.0:
                    await self._take(lease)
            if all(lease.expired_s >= 0.0 for lease in mine):
                return
            await self._sleep(RENEW_S / 4)

    async def _find_home(self) -> None:
        """Take a free shard for new rooms."""
        free = free_leases(self.view)
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
        on_disk, free = self._left, free_leases(self.view)
        self._left = frozenset()
        for lease in [lease for lease in free if lease.shard in on_disk][: max(0, len(free) - SPARE)]:
            if await self._take(lease):
                log.warning("took the shard %r: no node had its rooms or recordings in the data folder", lease.shard)

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
            log.error("the lease of %s is lost: another node goes on with it", lease_title(shard))
            self._close(shard)
        self.leases.shared |= shares_folder(self.who, self.view)
        for lease in to_take_over(self.who, self.view):
            if self._is_here(lease) and await self._take(lease):
                log.warning("took over the shard %r of node %s with %d rooms", lease.shard, lease.node, lease.rooms)
        await self._take_left()
        if not self.home and self.state == "serving":
            await self._find_home()
        await self._pass_study_on()
        await self._take_study()
        self.open_shards.open_all()
        await self._give_back()

    def _is_here(self, lease: LeaseRow) -> bool:
        """Whether the files of a shard are where they should be; those of this node's own last run are."""
        if lease.node == self.who.name or self._rooms.can_see(lease.shard):
            return True
        log.warning("the rooms of the shard %r are not in the data folder", lease.shard)
        return False

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
        failed = STUDY in self.leases and not self.open_shards.is_being_opened(STUDY) and self.study_tries.used_up
        lease = self.view.lease(STUDY)
        if failed and lease is not None and somebody_may_take(self.view, lease):
            log.error("%s; another node may try now", self.study_tries.problem)
            fence = self.leases.fence(STUDY)
            self.leases.dropped(STUDY)
            self.study_tries.given_back(self._clock())
            await self.store.release(self.who, STUDY, fence)
            self.view = await self.store.view()

    def _why_no_study(self) -> str:
        """Told to the others, so that nobody believes that the study is served here before it is."""
        opening = STUDY in self.leases and STUDY not in self.open_shards
        return self.study_tries.problem or (OPENING if opening else "")

    async def _give_back(self) -> None:
        for shard in self.open_shards:
            if shard not in (self.home, STUDY) and self._rooms.can_give_back(shard):
                fence = self.leases.fence(shard)
                self.leases.dropped(shard)
                self.open_shards.given_back(shard)
                await self.store.release(self.who, shard, fence)
                self._rooms.forget_shard(shard, fence)

    def _close_lapsed(self) -> None:
        """Rooms whose lease is over wait on the disk; they are opened again when the database says they are ours."""
        lapsed = [shard for shard in self.open_shards if not self.leases.valid(shard, self._clock())]
        for shard in lapsed:
            log.error("the lease of %s is over: it waits", lease_title(shard))
            self._close(shard)

    def _close(self, shard: str) -> None:
        if shard == self.home and shard not in self.leases:
            self.home = ""
        self.open_shards.close(shard)

    def _say(self, problem: str) -> None:
        if problem and not self.problem:
            log.error(
                "%s; rounds go on for %.0f s at most where another node has the folder too", problem, self.store.lease_s
            )
        elif self.problem and not problem:
            log.warning("the database answers again")
        self.problem = problem
