"""Nodes for the tests: alone with a list of what they were asked to do, and whole ones in this process."""

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from movingout.server.cluster.app import create_cluster_app
from movingout.server.cluster.host import ClusterHost
from movingout.server.cluster.node import ClusterNode
from tests.server.cluster.clock import TestClock, identity
from tests.server.live import Live, serve

LEASE_S = 15.0  # the machine may be busy


@dataclass
class FakeRooms:
    """A RoomKeeper that has as many rooms of each shard as a test says."""

    counts: dict[str, int] = field(default_factory=dict)
    done: list[str] = field(default_factory=list)
    visible: bool = True
    on_disk: frozenset[str] = frozenset()

    async def open_shard(self, shard: str, fence: int) -> None:
        self.done.append(f"open {shard}.{fence}")

    def close_shard(self, shard: str) -> None:
        self.done.append(f"close {shard}")

    def room_counts(self) -> dict[str, int]:
        return self.counts

    def can_give_back(self, shard: str) -> bool:
        return not self.counts.get(shard)

    def forget_shard(self, shard: str, fence: int) -> None:
        self.done.append(f"forget {shard}.{fence}")

    def can_see(self, shard: str) -> bool:
        return self.visible

    async def shards_on_disk(self) -> frozenset[str]:
        return self.on_disk


MADE: list["Node"] = []


class Node:
    """A node whose second passes when a test says so."""

    def __init__(
        self, clock: TestClock, name: str, study: bool = False, rooms: FakeRooms | None = None, **who: str
    ) -> None:
        self.rooms = rooms or FakeRooms()
        self.node = ClusterNode(identity(name, **who), clock.store(), self.rooms, clock, clock.sleep, study)
        MADE.append(self)

    async def start(self) -> "Node":
        await self.node.join()
        await self.node.open_shards.opened()
        return self

    async def step(self) -> None:
        await self.node.step()
        await self.node.open_shards.opened()
        await asyncio.sleep(0)  # nobody waits for the study


def together(story: Callable[[], Coroutine[Any, Any, None]]) -> None:
    async def whole() -> None:
        try:
            await story()
        finally:
            while MADE:
                await MADE.pop().node.store.close()

    asyncio.run(whole())


@contextmanager
def node(data: Path, database: str, name: str, **settings: Any) -> Iterator[Live]:
    """A whole node in a thread of this process."""
    with serve(data, app_of=create_cluster_app, cluster=database, node=name, lease_s=LEASE_S, **settings) as live:
        yield live


def host(live: Live) -> ClusterHost:
    return cast(ClusterHost, live.host)
