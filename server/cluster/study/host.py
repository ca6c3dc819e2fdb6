"""A node of a cluster that serves a study: its own rooms, and, while it runs the study, those of all nodes.

The node with the lease STUDY runs the study: it alone writes to the databases, which refuse every other fencing token,
and it alone opens and closes rooms, which every node refuses to whoever has an older token.
"""

import asyncio
import contextlib
import inspect
import logging
from collections.abc import Callable, Collection, Iterator
from typing import Any, Concatenate, Protocol

from movingout.agents.errors import AgentsBusyError
from movingout.maps import map_to_json
from movingout.recordings.episode import Outcome
from movingout.server.cluster.errors import ClusterError, NodeEnds
from movingout.server.cluster.host import FORMAT, ClusterHost
from movingout.server.cluster.lease_store import LeaseStore, NodeIdentity, NodeRow
from movingout.server.cluster.node import ClusterNode
from movingout.server.cluster.shards import SHARDS, STUDY, shard_of
from movingout.server.cluster.study import room_works
from movingout.server.cluster.study.room_works import NodeStatus, SeatPlan
from movingout.server.notices import NOTHING, Notice
from movingout.server.public_host import Away, Found, Given, NoRoom
from movingout.server.rooms.prepared_maps import KEPT, Variant
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings

log = logging.getLogger(__name__)

OPEN_S = 10.0  # for a room with its agents
ALL_THERE_S = 60.0  # that the study waits for rooms of nodes that are gone
LOOK_S = 0.3
SENT = KEPT // 2  # maps that a node is believed to have: beside them it keeps some of its own
FEWER_HERE = 20  # rooms, because this node also answers the pages of all participants


class StudyOfTheCluster(Protocol):
    """The study while this node runs it (server.cluster.study.app)."""

    async def begin(self, fence: int) -> None:
        """Go on with the study as the databases have it."""

    def let_go(self) -> None:
        """Do nothing more for the study, at once."""

    async def end(self) -> None:
        """Finish what `let_go` has begun."""


class StudyNodeHost(ClusterHost):
    """`study` is set before `start`; `kind` says which study this is, so that nodes of another one are refused."""

    study: StudyOfTheCluster

    def __init__(self, settings: Settings, kind: str) -> None:
        self._kind = kind
        self._newest_fence = 0
        super().__init__(settings)
        self.checks.append(self._study_faults)
        self._sent: dict[str, dict[Variant, None]] = {}  # randomised maps that each run of a node has, oldest first
        self._telling: set[asyncio.Task[None]] = set()

    def _node_of(self, who: NodeIdentity) -> ClusterNode:
        return ClusterNode(who, LeaseStore(self.settings.cluster, lease_s=self.settings.lease_s), self, study=True)

    def _format(self) -> str:
        return f"{FORMAT}, {self._kind}"

    async def stop(self) -> None:
        """A study that is still being begun is given up: its lease would run out before it is given back."""
        await self.suspend()  # from now on no study is begun here
        await self.node.open_shards.stop_opening(STUDY)
        self.study.let_go()
        await self.study.end()
        await super().stop()

    # ---- who runs the study -----------------------------------------------------------------------------------

    def _study_faults(self) -> Iterator[str]:
        if self.node.study_tries.problem:
            yield self.node.study_tries.problem

    def in_charge(self) -> bool:
        """Whether this node, and no other, may act for the study."""
        return self.node.leases.valid(STUDY, self.node.now())

    def obey(self, fence: int) -> None:
        """Raises Away for a study that another node runs by now."""
        lease = self.node.view.lease(STUDY)
        self._newest_fence = max(self._newest_fence, fence, lease.fence if lease else 0)
        if fence < self._newest_fence:
            raise Away("another node runs the study now")

    def _fence(self) -> int:
        """Raises Away unless this node runs the study."""
        if not self.in_charge():
            raise Away("another node runs the study now")
        return self.node.leases.fence(STUDY)

    async def open_shard(self, shard: str, fence: int) -> None:
        if shard != STUDY:
            await super().open_shard(shard, fence)
            return
        begun = self.node.now()
        await self._all_there()
        found = self.node.now()
        await self.study.begin(fence)
        log.warning(
            "the study goes on here: rooms found in %.1f s, then %.1f s", found - begun, self.node.now() - found
        )

    def close_shard(self, shard: str) -> None:
        if shard == STUDY:
            self.study.let_go()
        else:
            super().close_shard(shard)

    async def _all_there(self) -> None:
        """Wait until every room that there is can be asked: one that comes later would be played twice.

        Raises NodeEnds where this node ends meanwhile: it no longer takes what the others have left, nor ends a study.
        """
        deadline = self.node.now() + ALL_THERE_S
        while not self.stopping and (missing := await self._missing()):
            if self.node.now() > deadline:
                log.error("the rooms of the shards %s are nowhere; the study goes on without them", ", ".join(missing))
                break
            await asyncio.sleep(LOOK_S)
        if self.stopping:
            raise NodeEnds("this node ends")

    async def _missing(self) -> list[str]:
        """Shards whose rooms cannot be asked yet: nobody has them, or this node has not read from the database who."""
        there = {(shard, name) for name, status in (await self._statuses()).items() for shard in status.shards}
        leases = [lease for lease in self.node.view.leases if lease.node and lease.shard != STUDY]
        lost = [one.shard for one in leases if one.expired_s > 0.0 or (one.shard, one.node) not in there]
        return [shard for shard in lost if self.node.comes_back_soon(shard)]

    # ---- rooms wherever they are ------------------------------------------------------------------------------

    def why_no_room(self) -> str:
        return self.refusal().message or super().cannot_record().message

    def cannot_record(self) -> Notice:
        """NOTHING, whatever this node can do: `open_room` takes a node that records, and says why where none does."""
        return NOTHING

    def shards_here(self) -> list[str]:
        return [shard for shard in self.node.open_shards if shard in SHARDS and self.node.serves(shard)]

    def is_gone(self, room_id: str) -> bool:
        return self.node.serves(shard_of(room_id)) and room_id not in self._awaiting_agents

    async def _call(self, node: NodeRow, work: Callable[..., Any], *args: Any, within_s: float = 3.0) -> Any:
        """What `work(host, fence, ...)` returns at a node. Raises Away."""
        fence = self._fence()
        if node.run == self.node.who.run:
            found = work(self, fence, *args)
            return await found if inspect.isawaitable(found) else found
        return await self._caller.call(node.address, node.run, work, fence, *args, within_s=within_s)

    def _holder(self, room_id: str) -> NodeRow:
        """The node that has a room. Raises Away, and NoRoom where nobody has its shard."""
        lease = self.node.view.lease(shard_of(room_id))
        if lease is None or lease.node is None:
            raise NoRoom(f"there is no room {room_id}")
        node = self.node.view.node(lease.node)
        if node is None or not node.alive or lease.expired_s > 0.0:
            raise Away("the node of this room has ended; another one goes on with it in a moment")
        return node

    async def _statuses(self) -> dict[str, NodeStatus]:
        """By node, of those that answer."""
        nodes = self._nodes()
        found = await asyncio.gather(
            *(self._call(node, room_works.node_status) for node in nodes), return_exceptions=True
        )
        return {node.name: each for node, each in zip(nodes, found, strict=True) if isinstance(each, NodeStatus)}

    async def open_room(self, config: RoomConfig, seats: list[Seat]) -> str:
        """At the node with the fewest rooms; where its agents are all busy, at the next one. Raises as PublicHost."""
        statuses, plans = await self._statuses(), [SeatPlan.of(seat) for seat in seats]
        why = "; ".join(f"{name}: {each.refusal}" for name, each in statuses.items() if each.refusal)
        problem: AgentsBusyError | Away = Away(f"no node takes a room at the moment ({why or 'none answers'})")
        able = [node for node in self._nodes() if node.name in statuses and not statuses[node.name].refusal]
        for node in sorted(able, key=lambda each: statuses[each.name].rooms + self._handicap(each)):
            try:
                room_id = await self._call(node, room_works.open_study_room, config, plans, within_s=OPEN_S)
            except (AgentsBusyError, Away) as error:
                problem = error
                continue
            return str(room_id)
        raise problem

    def _handicap(self, node: NodeRow) -> int:
        return FEWER_HERE if node.run == self.node.who.run else 0

    async def ask(
        self,
        room_id: str,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found:
        if room_id in self.registry.rooms or work not in room_works.ROOM_WORKS:
            return await super().ask(room_id, work, *args, **kwargs)
        found: Found = await self._call(self._holder(room_id), room_works.ROOM_WORKS[work], room_id, *args)
        return found

    async def close_room(self, room_id: str, code: int, notice: Notice, outcome: Outcome = "stopped") -> PlayedRound:
        if room_id in self.registry.rooms:
            return await super().close_room(room_id, code, notice, outcome)
        work = room_works.close_study_room
        played: PlayedRound = await self._call(self._holder(room_id), work, room_id, code, notice, outcome)
        return played

    async def look(self, rooms: Collection[str]) -> dict[str, RoomView | None]:
        found: dict[str, RoomView | None] = {}
        by_node: dict[str, list[str]] = {}
        for room_id in rooms:
            try:
                by_node.setdefault(self._holder(room_id).name, []).append(room_id)
            except NoRoom:
                found[room_id] = None
            except Away:
                continue
        nodes = [node for node in self._nodes() if node.name in by_node]
        asked = (self._call(node, room_works.look_at, by_node[node.name]) for node in nodes)
        for each in await asyncio.gather(*asked, return_exceptions=True):
            if isinstance(each, dict):
                found |= each
        return found

    @property
    def shares_recordings(self) -> bool:
        return True

    def reaches(self, room_id: str) -> bool:
        with contextlib.suppress(Away, NoRoom):
            return self._holder(room_id).alive
        return False

    async def study_rooms(self) -> list[str]:
        return [room_id for status in (await self._statuses()).values() for room_id in status.study_rooms]

    # ---- what rooms need, and tell ----------------------------------------------------------------------------

    async def _prepare(self, wanted: list[Variant], address: str) -> None:
        await super()._prepare(wanted, address)
        for variant in wanted:
            others = [node for node in self._nodes() if node.run != self.node.who.run]
            for node in [node for node in others if variant not in self._sent.get(node.run, {})]:
                designed, seed, split = variant
                made = map_to_json(self.prepared_maps.world_map(designed, seed, split))
                with contextlib.suppress(Away):
                    await self._call(node, room_works.keep_map, map_to_json(designed), seed, split, made)
                    self._note_sent(node.run, variant)

    def _note_sent(self, run: str, variant: Variant) -> None:
        """Forgets the oldest, as the node does, and runs that have ended."""
        alive = {node.run for node in self._nodes()}
        self._sent = {each: sent for each, sent in self._sent.items() if each in alive}
        sent = self._sent.setdefault(run, {})
        sent[variant] = None
        while len(sent) > SENT:
            del sent[next(iter(sent))]

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        """To the node that runs the study, which also looks once a second in case it does not hear of it."""
        if self.in_charge():
            self.round_heard(room_id, played)
            return
        lease = self.node.view.lease(STUDY)
        node = self.node.view.node(lease.node) if lease is not None else None
        if node is not None and node.run != self.node.who.run:
            task = asyncio.create_task(self._tell(node, room_id, played))
            self._telling.add(task)
            task.add_done_callback(self._telling.discard)

    def round_heard(self, room_id: str, played: PlayedRound) -> None:
        """Does nothing where this node does not run the study."""
        for watcher in self.round_watchers:
            watcher(room_id, played)

    async def _tell(self, node: NodeRow, room_id: str, played: PlayedRound) -> None:
        with contextlib.suppress(Away, ClusterError):
            await self._caller.call(node.address, node.run, room_works.tell_round_over, room_id, played)
