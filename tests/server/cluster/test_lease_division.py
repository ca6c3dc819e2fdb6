"""Each lease that has expired goes to one of the nodes that may have it, without a word between them."""

from dataclasses import replace

import pytest

from movingout.server.cluster.lease_division import somebody_may_take, to_take_over
from movingout.server.cluster.lease_store import ClusterView, LeaseRow, NodeIdentity, NodeRow
from tests.server.cluster.clock import identity


def row(who: NodeIdentity, **fields: object) -> NodeRow:
    described = {"state": "serving", "rooms": 0, "alive": True} | fields
    return NodeRow(who.name, who.folder, who.version, who.format, who.address, run=who.run, **described)  # type: ignore[arg-type]


NODES = [identity(name) for name in "abc"]
ALIVE = tuple(map(row, NODES))
GONE = identity("gone")
LEFT = tuple(
    LeaseRow(
        shard, fence=1, node=GONE.name, run=GONE.run, folder="shared", format="1", shared=True, rooms=1, expired_s=2.0
    )
    for shard in "fghjk"
)


def test_nodes_divide_among_themselves_what_another_one_left() -> None:
    view = ClusterView(LEFT, (*ALIVE, row(GONE, alive=False)))
    parts = [[lease.shard for lease in to_take_over(who, view)] for who in NODES]
    assert parts == [["f", "j"], ["g", "k"], ["h"]]


def test_what_a_node_left_itself_goes_to_its_next_run() -> None:
    own = replace(LEFT[0], node="b", run="the run before of b")
    parts = [[*to_take_over(who, ClusterView((own,), ALIVE))] for who in NODES]
    assert parts == [[], [own], []]


@pytest.mark.parametrize(
    "node", [{"alive": False}, {"state": "draining"}, {"folder": "another"}, {"format": "2"}], ids=str
)
def test_a_node_that_could_not_go_on_with_the_rooms_takes_none(node: dict[str, object]) -> None:
    unfit = replace(ALIVE[0], **node)  # type: ignore[arg-type]
    view = ClusterView(LEFT, (unfit,))
    assert not somebody_may_take(view, LEFT[0]) and [*to_take_over(NODES[0], view)] == []
