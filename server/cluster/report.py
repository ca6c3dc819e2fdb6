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


def unserved_study(view: ClusterView) -> str:
    """Since when nobody serves a study that has begun, and what to do; empty where it is served.

    Empty too after all of its nodes have ended in order: somebody wanted it so. Where one of them died before, nobody
    may know that the node that was ended was the last one.
    """
    lease = view.lease(STUDY)
    if lease is None or lease.fence == 0 or any(has_lease(node, lease) and not node.problem for node in view.nodes):
        return ""
    nodes = [node for node in view.nodes if lease.format in (None, node.format)]
    if all(node.state == "ended" for node in nodes):
        return ""
    last = f"node {lease.node} had it last" if lease.node else "the node that had it last gave it back"
    when = f", {_lasting(lease.expired_s)} ago" if lease.expired_s > 0.0 else ""
    able = [node.name for node in nodes if node.alive and node.state == "serving"]
    if able:
        todo = f"it is to go on within moments at {' or '.join(able)}, or the log there says why it does not"
    else:
        todo = "to go on with it, start a node: movingout study serve FILE --cluster URL --node NAME"
    return f"nobody serves the study: {last}{when}; {todo}"


def _lasting(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200.0 else f"{seconds / 3600:.0f} h"


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
