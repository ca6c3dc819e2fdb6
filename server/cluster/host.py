"""A server that is a node of a cluster: its rooms are those of the shards that it has."""

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Any, Concatenate

import movingout
from movingout.agents.errors import AgentsBusyError
from movingout.maps import MovingOutError
from movingout.server import messages as m
from movingout.server.agent_workers.capacity import COSTS, AgentCosts
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.joining import refuse_other_clusters
from movingout.server.cluster.lease_store import LeaseStore, NodeIdentity, NodeRow
from movingout.server.cluster.limit_store import LimitStore
from movingout.server.cluster.node import LOOK_S, ClusterNode
from movingout.server.cluster.node_calls import NodeCaller
from movingout.server.cluster.report import cluster_report, tokens_apart
from movingout.server.cluster.room_files import (
    ShardedRoomStore,
    adopt,
    discard,
    folder_id,
    has_files_of,
    has_rooms_of,
    journals_of,
    shards_in,
)
from movingout.server.cluster.shards import SHARDS, new_id_in, shard_of
from movingout.server.cluster.shared_limits import SHARE_S, SharedLimits
from movingout.server.connection.closing import CloseConnection
from movingout.server.connection.other_nodes import RoomCount
from movingout.server.host import Host
from movingout.server.notices import NOTHING, ErrorCode, Notice
from movingout.server.persistence.room_snapshot import interrupted_round, room_again
from movingout.server.persistence.room_store import VERSION, RoomFile
from movingout.server.public_host import Away, Found, Given, NoRoom, PublicHost
from movingout.server.room_host import RoomHost, warm_up
from movingout.server.rooms.room import Room
from movingout.server.security.certificate import lan_addresses
from movingout.server.security.tokens import new_id
from movingout.server.settings import Settings

log = logging.getLogger(__name__)

FORMAT = f"rooms {VERSION}, {m.SUBPROTOCOL}"
SETTLE_S = 10.0  # for recordings to be finished before the rooms are handed over
AGENTS_AGAIN_S = 2.0
MOVING = Notice("moving", "This game is moving to another machine. It continues in a few seconds.")
WAITS = Notice(
    "room_waits",
    "The machine with this game cannot be reached. The game waits, and this page reconnects automatically.",
)
NOT_YET = Notice("restarting", "The server is being restarted; try again in a minute.")


class RoomElsewhere(Away):
    """The room is not at this node at the moment."""

    def __init__(self, notice: Notice, code: ErrorCode) -> None:
        super().__init__(notice.message)
        self.code = code


class ClusterHost(Host):
    """Raises ClusterError where the settings are no node of a cluster."""

    def __init__(self, settings: Settings) -> None:
        PublicHost.__init__(self, settings)
        costs = AgentCosts(settings.node_folder / COSTS)
        agents = AgentPool(
            settings.agent_workers,
            costs=costs,
            thread_cores=settings.agent_thread_cores,
            slow_agents=settings.slow_agents,
        )
        self._awaiting_agents: dict[str, RoomFile] = {}  # rooms that come back when an agent is free
        self._secret = ""
        self.node: ClusterNode = self._make_node()
        self._caller = NodeCaller(self.node.who.run, self.secret)
        RoomHost.__init__(self, settings, new_room_id=self._new_room_id, agents=agents)
        limits = LimitStore(settings.cluster, lease_s=settings.lease_s)
        self.shared_limits = SharedLimits(self.node.who.run, limits, settings.limits, self._rooms_by_owner)
        self.admission.other_nodes = self.shared_limits

    def _make_node(self) -> ClusterNode:
        settings = self.settings
        try:
            folder = folder_id(settings.data)
        except OSError as error:
            raise ClusterError(f"cannot write to the data folder {settings.data} ({error.strerror})") from None
        who = NodeIdentity(
            name=settings.node,
            run=new_id(20),
            folder=folder,
            version=movingout.__version__,
            format=self._format(),
            address=_reached_at(settings),
        )
        return self._node_of(who)

    def _node_of(self, who: NodeIdentity) -> ClusterNode:
        return ClusterNode(who, LeaseStore(self.settings.cluster, lease_s=self.settings.lease_s), self)

    def _format(self) -> str:
        return FORMAT

    def secret(self) -> str:
        """That of the cluster; empty before this node has joined it."""
        return self._secret

    # ---- start and stop -------------------------------------------------------------------------------------

    async def check_cluster(self) -> None:
        """Raise ClusterError if this node may not join; in an event loop of its own, before the server starts."""
        node = self._node_of(self.node.who)
        try:
            await node.check()
            await refuse_other_clusters(self.settings.data, self.settings.node, await node.store.cluster())
        finally:
            await node.store.close()

    async def start(self) -> None:
        """Join the cluster, go on with the rooms of this node's last run, and start to tick."""
        self._start_public()
        await self.agents.start()
        warm_up()
        await self.node.store.prepare()
        self._secret = await self.node.store.secret()
        await self.node.join()
        if sentence := tokens_apart(self.node.view, self.node.who):
            log.warning("%s", sentence)
        self.shared_limits.begin(self._secret)
        self.admission.name_owners_by(self._secret)
        self.node.begin()
        await self.node.open_shards.opened()
        await self.start_rooms()
        self.background.repeat("rooms that wait for an agent", self._bring_awaiting, AGENTS_AGAIN_S)
        self.background.repeat("limits of addresses", self.shared_limits.share, SHARE_S)
        self.background.repeat("recordings that no node has", self._recover_left, LOOK_S)

    async def stop(self) -> None:
        """Hand the rooms over: first everything about them is on the disk, then the leases end."""
        await self.suspend()
        await asyncio.to_thread(self.store.flush)
        try:
            await asyncio.wait_for(self.recording_service.settled(), SETTLE_S)
        except TimeoutError:
            log.warning("recordings are being finished still; another node may do so")
        await self.node.leave()
        await self._stop_public()
        await self.stop_rooms()
        await self.shared_limits.close()

    async def drain(self, within_s: float) -> None:
        self.node.state = "draining"
        await super().drain(within_s)

    # ---- what rooms are here --------------------------------------------------------------------------------

    def owns(self, room_id: str) -> bool:
        return self.node.leases.valid(shard_of(room_id), self.node.now())

    def _new_room_id(self) -> str:
        return new_id_in(self.node.home)

    def _room_store(self) -> ShardedRoomStore:
        return ShardedRoomStore(self.settings.rooms, lambda shard: self.node.leases.fences.get(shard))

    def absence(self, room_id: str) -> CloseConnection:
        """How a connection ends if its room is not here."""
        notice = self._absence(room_id)
        return super().absence(room_id) if notice is None else CloseConnection(m.CLOSE_SHUTDOWN, notice)

    def _absence(self, room_id: str) -> Notice | None:
        """Where a room is that is not here; None if it is nowhere."""
        shard = shard_of(room_id)
        if not shard or (self.node.serves(shard) and room_id not in self._awaiting_agents):
            return None
        soon = self.node.comes_back_soon(shard)
        return None if soon is None else MOVING if soon and not self.node.problem else WAITS

    async def ask(
        self,
        room_id: str,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found:
        try:
            return await super().ask(room_id, work, *args, **kwargs)
        except NoRoom:
            notice = self._absence(room_id)
            if notice is None:
                raise
            raise RoomElsewhere(notice, "moving" if notice is MOVING else "room_waits") from None

    async def close_rooms_owned_by(self, owner: str, code: int, notice: Notice) -> int:
        """Close them at all nodes: an owner has the same name everywhere. A node that does not answer keeps its own."""
        if not owner:
            return 0
        work, others = close_rooms_owned_by, [row for row in self._nodes() if row.run != self.node.who.run]
        calls = (self._caller.call(row.address, row.run, work, owner, code, notice) for row in others)
        answers = await asyncio.gather(*calls, return_exceptions=True)
        for row, answer in zip(others, answers, strict=True):
            if isinstance(answer, BaseException):
                log.warning("rooms of an address at node %s were not closed: %s", row.name, answer)
        closed_there = sum(answer for answer in answers if isinstance(answer, int))
        return closed_there + await super().close_rooms_owned_by(owner, code, notice)

    async def close_owned_here(self, owner: str, code: int, notice: Notice) -> int:
        return await super().close_rooms_owned_by(owner, code, notice)

    def _nodes(self) -> list[NodeRow]:
        return [node for node in self.node.view.nodes if node.alive]

    # ---- what the node asks for (RoomKeeper) ----------------------------------------------------------------

    async def open_shard(self, shard: str, fence: int) -> None:
        """Bring the rooms here one by one, so that the rooms of other shards tick on."""
        await asyncio.to_thread(adopt, self.settings.rooms, self.settings.recordings, shard, fence)
        assert isinstance(self.store, ShardedRoomStore)
        for file in await asyncio.to_thread(lambda store: list(store.load_shard(shard, fence)), self.store):
            if file.id not in self.registry.rooms:
                await self._bring(file, shard)
        self._recover_shard(shard)

    async def _bring(self, file: RoomFile, shard: str) -> None:
        interrupted = await asyncio.to_thread(interrupted_round, file, self.settings.recordings)
        await self.prepare_map(file)
        if not self.node.leases.valid(shard, self.node.now()):
            if interrupted is not None:
                interrupted.writer.abandon()
            raise ClusterError(f"the lease of the shard {shard!r} was lost while its rooms were being opened")
        try:
            with self.agents.already_seated():
                room = room_again(file, interrupted, self.registry, time.monotonic())
            self.came_back(room)
            self._awaiting_agents.pop(file.id, None)
        except AgentsBusyError as error:  # those of another node's rooms came in addition
            if file.id not in self._awaiting_agents:
                log.warning("room %s waits for an agent: %s", file.id, error)
            self._awaiting_agents[file.id] = file
        except MovingOutError as error:
            self._awaiting_agents.pop(file.id, None)
            self.cannot_open(file, error)

    async def _bring_awaiting(self) -> None:
        for file in list(self._awaiting_agents.values()):
            if self.node.serves(shard_of(file.id)):
                await self._bring(file, shard_of(file.id))

    def _recover_shard(self, shard: str) -> None:
        """Finish the recordings of rounds that no room goes on with."""
        running = {*self.episodes(), *(file.episode for file in self._awaiting_agents.values())}
        for journal in journals_of(self.settings.recordings, shard):
            name = journal.name.partition(".")[0]
            if name not in running and not self.recording_service.knows(journal):
                self.recording_service.recover(journal)

    async def _recover_left(self) -> None:
        """Finish what this folder has of shards that a node with another folder holds; one of its nodes does this."""
        on_disk, who = await self.node.look(), self.node.who
        first = min((node.name for node in self._nodes() if node.folder == who.folder), default="")
        if self.node.problem or first != who.name:
            return
        for lease in self.node.view.leases:
            elsewhere = lease.node is not None and lease.folder != who.folder and lease.expired_s < 0.0
            if elsewhere and lease.shard in SHARDS and lease.shard in on_disk:
                self._recover_shard(lease.shard)

    def close_shard(self, shard: str) -> None:
        for room in [room for room in self.registry.rooms.values() if shard_of(room.id) == shard]:
            room.suspend(MOVING)
            self.registry.let_go(room)
            self.admission.closed_room(room.id)
        for room_id in [each for each in (*self._awaiting_agents, *self.not_opened) if shard_of(each) == shard]:
            self._awaiting_agents.pop(room_id, None)
            self.not_opened.pop(room_id, None)

    def room_counts(self) -> dict[str, int]:
        counts: dict[str, int] = {}
        for room_id in (*self.registry.rooms, *self._awaiting_agents):
            counts[shard_of(room_id)] = counts.get(shard_of(room_id), 0) + 1
        return counts

    def _rooms_by_owner(self) -> dict[str, RoomCount]:
        found = {}
        for owner, (new, ids) in self.admission.rooms_by_owner().items():
            rooms = [room for each in ids if (room := self.registry.rooms.get(each)) is not None]
            unjoined = sum(not (room.was_joined or room.seating.clients) for room in rooms)
            found[owner] = RoomCount(open=new + len(rooms), unjoined=new + unjoined)
        return found

    def can_give_back(self, shard: str) -> bool:
        return (
            shard not in self.room_counts()
            and not journals_of(self.settings.recordings, shard)
            and not has_files_of(self.settings.rooms, shard)
        )

    def forget_shard(self, shard: str, fence: int) -> None:
        discard(self.settings.rooms, shard, fence)

    def can_see(self, shard: str) -> bool:
        return has_rooms_of(self.settings.rooms, shard)

    async def shards_on_disk(self) -> frozenset[str]:
        return await asyncio.to_thread(shards_in, self.settings.rooms, self.settings.recordings)

    # ---- what people and proxies are told -------------------------------------------------------------------

    def refusal(self, for_operator: bool = False) -> Notice:
        return super().refusal(for_operator) or (NOTHING if self.node.takes_rooms else NOT_YET)

    def why_not_ready(self) -> list[str]:
        reasons = super().why_not_ready()
        if not self.node.problem:
            return reasons
        return [*(reason for reason in reasons if reason != NOT_YET.message), self.node.problem]

    async def report(self) -> dict[str, Any]:
        return {**await super().report(), "cluster": cluster_report(self.node)}


async def close_rooms_owned_by(host: ClusterHost, owner: str, code: int, notice: Notice) -> int:
    """Called by another node: how many rooms of this owner were closed here."""
    return await host.close_owned_here(owner, code, notice)


WORKS = (close_rooms_owned_by,)
"""What any node may ask of another one."""


def _reached_at(settings: Settings) -> str:
    """Where other nodes find this one."""
    everywhere = settings.host in ("0.0.0.0", "::")
    host = next(iter(lan_addresses()), "127.0.0.1") if everywhere else settings.host
    return f"[{host}]:{settings.port}" if ":" in host else f"{host}:{settings.port}"
