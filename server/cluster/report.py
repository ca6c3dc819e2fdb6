"""The cluster as the admin's state tells it."""

from typing import Any

from movingout.server.cluster.node import ClusterNode


def cluster_report(node: ClusterNode) -> dict[str, Any]:
    """Nodes, which shards each has, and which rooms wait."""
    shards: dict[str | None, list[str]] = {}
    for lease in node.view.leases:
        shards.setdefault(lease.node, []).append(lease.shard)
    return {
        "node": node.who.name,
        "home": node.home,
        "problem": node.problem,
        "waiting": list(node.waiting()),
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
