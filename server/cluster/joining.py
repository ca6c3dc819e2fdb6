"""Which nodes fit together: what a node is told that may not join."""

import asyncio
from pathlib import Path

from movingout.maps.files.file_lock import is_locked
from movingout.server.cluster.errors import ClusterError, NodeRefused
from movingout.server.cluster.lease_store import ClusterView, NodeIdentity, NodeRow
from movingout.server.persistence.data_folder import LOCK
from movingout.server.settings import NODES

CLUSTER = "cluster"  # in the folder of a node: the cluster that it belongs to
STARTING_S = 10  # for others that start now to note theirs


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


async def refuse_other_clusters(data: Path, name: str, cluster: str) -> None:
    """Note which cluster a node belongs to; raise NodeRefused while nodes of another one use its data folder.

    Each database gives shards and fencing tokens away, so that both would have the same rooms. Raises ClusterError.
    """
    try:
        (data / NODES / name).mkdir(parents=True, exist_ok=True)
        (data / NODES / name / CLUSTER).write_text(cluster, encoding="ascii")
        for left_s in range(STARTING_S, -1, -1):
            others = _of_other_clusters(data, name, cluster)
            if not others:
                return
            await asyncio.sleep(min(left_s, 1))
    except OSError as error:
        raise ClusterError(f"cannot use the data folder {data} ({error.strerror or error})") from None
    raise NodeRefused(
        f"nodes of another cluster use the data folder {data} ({', '.join(others)}): end all of them first, or give "
        "this node their database (--cluster) or a data folder of its own (--data). A restored database counts as "
        "another one"
    )


def _of_other_clusters(data: Path, name: str, cluster: str) -> list[str]:
    """Nodes that run and have noted another cluster. Raises OSError."""
    found = []
    for note in sorted((data / NODES).glob(f"*/{CLUSTER}")):
        lock, said = note.with_name(LOCK), note.read_text(encoding="ascii", errors="replace")
        if note.parent.name != name and said not in ("", cluster) and is_locked(lock):
            found.append(note.parent.name)
    return found
