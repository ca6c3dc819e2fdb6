"""Nodes for the tests: alone with a list of what they were asked to do, and whole ones in this process."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from movingout.server.cluster.app import create_cluster_app
from movingout.server.cluster.host import ClusterHost
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


@contextmanager
def node(data: Path, database: str, name: str, **settings: Any) -> Iterator[Live]:
    """A whole node in a thread of this process."""
    with serve(data, app_of=create_cluster_app, cluster=database, node=name, lease_s=LEASE_S, **settings) as live:
        yield live


def host(live: Live) -> ClusterHost:
    return cast(ClusterHost, live.host)
