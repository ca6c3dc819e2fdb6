"""Which node goes on with which lease: all nodes that are alive come to the same division. Pure."""

from collections.abc import Iterator

from movingout.server.cluster.lease_store import FORGET_S, ClusterView, LeaseRow, NodeIdentity, NodeRow
from movingout.server.cluster.shards import SHARDS


def free_leases(view: ClusterView) -> list[LeaseRow]:
    """Those of shards that nobody has or waits for."""
    return [
        lease for lease in view.leases if lease.shard in SHARDS and (lease.node is None or lease.expired_s > FORGET_S)
    ]


def left_by_last_run(who: NodeIdentity, view: ClusterView) -> list[LeaseRow]:
    """What an earlier run of this node had and this one can go on with, also where its lease lasts still."""
    mine = [lease for lease in view.leases if lease.node == who.name and lease.run != who.run]
    return [lease for lease in mine if lease.folder == who.folder and lease.format == who.format]


def to_take_over(who: NodeIdentity, view: ClusterView) -> Iterator[LeaseRow]:
    """This node's part of the shards that are to be taken over.

    What an earlier run of a node had goes to that node, also when its lease was longer than the node waited.
    """
    expired = [each for each in view.leases if each.node is not None and each.expired_s > 0]
    for position, lease in enumerate(lease for lease in expired if lease.shard in SHARDS):
        able = [node.name for node in view.nodes if _may_take(node, lease)]
        is_own = lease.node == who.name and lease.node in able
        if is_own or (who.name in able and lease.node not in able and able[position % len(able)] == who.name):
            yield lease


def somebody_may_take(view: ClusterView, lease: LeaseRow) -> bool:
    """Whether there is a node that may go on with an expired lease."""
    return any(_may_take(node, lease) for node in view.nodes)


def shares_folder(who: NodeIdentity, view: ClusterView) -> bool:
    """Whether another node can reach the data folder of this one."""
    return any(node.folder == who.folder and node.name != who.name for node in view.nodes)


def _may_take(node: NodeRow, lease: LeaseRow) -> bool:
    """Whether a node may go on with an expired lease; the run that let it expire renews it or has lost it."""
    return (
        (lease.shared or lease.node == node.name)
        and node.run != lease.run
        and node.alive
        and node.state == "serving"
        and (node.folder, node.format) == (lease.folder, lease.format)
    )
