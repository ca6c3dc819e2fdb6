"""Which nodes fit together: what a node is told that may not join."""

from movingout.server.cluster.errors import NodeRefused
from movingout.server.cluster.lease_store import ClusterView, NodeIdentity, NodeRow


def refuse_unfit(who: NodeIdentity, view: ClusterView, study: bool) -> None:
    """Raise NodeRefused, with what would work, for a node that does not fit to those that run."""
    others = [node for node in view.nodes if node.alive and node.name != who.name]
    if foreign := [node for node in others if node.format != who.format]:
        raise NodeRefused(_why_foreign(who, foreign))
    if study and (strangers := [node.name for node in others if node.folder != who.folder]):
        raise NodeRefused(
            "the nodes of a study share one data folder, and this node has another one than "
            f"{', '.join(strangers)}: start it with theirs (--data)"
        )
    if any(lease.node == who.name and lease.folder != who.folder and lease.rooms for lease in view.leases):
        raise NodeRefused(
            f"the rooms of node {who.name} lie in another data folder: start it with that one, or give this "
            "node a name of its own: --node NAME"
        )


def _why_foreign(who: NodeIdentity, foreign: list[NodeRow]) -> str:
    if all(node.version == who.version for node in foreign):
        return (
            f"this node serves something else than the running nodes ({', '.join(node.name for node in foreign)}): "
            "start it with the same command, study file and options, or end those nodes first"
        )
    names = ", ".join(f"{node.name}: {node.version}" for node in foreign)
    return (
        f"this node has version {who.version}, and its rooms do not fit those of the running nodes "
        f"({names}): end these first (SIGUSR1 lets their rounds end), or start the same version"
    )
