"""The cluster as whoever runs it is told."""

from collections.abc import Iterator
from typing import Any

from movingout.server.cluster.lease_store import FORGET_S, ClusterView, LeaseRow, NodeIdentity, NodeRow
from movingout.server.cluster.node import ClusterNode
from movingout.server.cluster.shards import STUDY


def cluster_report(node: ClusterNode) -> dict[str, Any]:
    """Nodes, which shards each has, and which rooms wait."""
    shards: dict[str | None, list[str]] = {}
    for lease in node.view.leases:
        shards.setdefault(lease.node, []).append(lease.shard)
    return {
        "node": node.who.name,
        "home": node.home,
        "problem": node.problem,
        "waiting": list(waiting_rooms(node.view, node.store.lease_s)),
        "nodes": [
            {
                "name": row.name,
                "version": row.version,
                "address": row.address,
                "state": row.state if row.alive else "away" if row.state != "ended" else "ended",
                "rooms": row.rooms,
                "shards": shards.get(row.name, []),
            }
            for row in node.view.nodes
        ],
    }


def waiting_rooms(view: ClusterView, lease_s: float) -> Iterator[str]:
    """A sentence for each node that is away for a lease and more, and whose rooms nobody else can go on with."""
    silent: dict[str, list[LeaseRow]] = {}
    for lease in view.leases:
        if lease.node is not None and lease.rooms and lease_s < lease.expired_s < FORGET_S:
            silent.setdefault(lease.node, []).append(lease)
    for node, leases in silent.items():
        count = sum(lease.rooms for lease in leases)
        rooms = "1 room waits" if count == 1 else f"{count} rooms wait"
        beginnings = ", ".join(lease.shard for lease in leases)
        away_s = min(lease.expired_s for lease in leases)
        yield f"node {node} has been away for {away_s:.0f} s: {rooms} for it (ids beginning with {beginnings})"


def unserved_study(view: ClusterView, lease_s: float) -> str:
    """A sentence where nobody serves a study that has begun; empty after who had it last has ended in order.

    Unless another node was there at that moment: it was to go on with it.
    """
    lease = view.lease(STUDY)
    if lease is None or lease.fence == 0 or any(has_lease(node, lease) and not node.problem for node in view.nodes):
        return ""
    if all(node.state == "ended" or lease.format not in (None, node.format) for node in view.nodes):
        return ""
    holder = view.node(lease.node)
    others = [node for node in view.nodes if node.state != "ended"]
    if holder is not None and holder.state == "ended" and all(_was_away(node, lease, lease_s) for node in others):
        return ""
    return "nobody serves the study" + (f": node {lease.node} had it last" if lease.node else "")


def _was_away(node: NodeRow, lease: LeaseRow, lease_s: float) -> bool:
    """Whether a node was away already when a lease ended."""
    return node.seen_s - max(lease.expired_s, 0.0) > lease_s


def has_lease(node: NodeRow, lease: LeaseRow) -> bool:
    return node.alive and lease.node == node.name and lease.expired_s <= 0.0


def tokens_apart(view: ClusterView, who: NodeIdentity) -> str:
    """What the operator does where another node has another data folder, and so another admin token; or empty."""
    others = [node.name for node in view.nodes if node.alive and node.folder != who.folder]
    if not others:
        return ""
    return (
        f"the data folder of {', '.join(others)} is another one, with an admin token of its own; behind one proxy all "
        "nodes need the same: copy admin-token from one folder to the others and start these nodes again"
    )
