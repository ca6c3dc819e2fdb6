"""When a node that has just become the one that runs the study may begin."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest

from movingout.server.cluster.lease_store import ClusterView, LeaseRow
from movingout.server.cluster.study.host import StudyNodeHost
from movingout.server.cluster.study.room_works import NodeStatus
from movingout.server.notices import NOTHING, Notice
from movingout.server.public_host import PublicHost


def lease(shard: str, node: str | None, expired_s: float = -5.0) -> LeaseRow:
    return LeaseRow(shard, 1, node, "run", "folder", "format", True, 1, expired_s)


class Host(StudyNodeHost):
    """Node b, which knows `leases` from the database and where other nodes say that their rooms are."""

    def __init__(self, leases: list[LeaseRow], **shards: str) -> None:
        view = ClusterView(tuple(leases), ())
        self.node = cast(Any, SimpleNamespace(view=view, comes_back_soon=lambda shard: True))
        self._shards = shards

    async def _statuses(self) -> dict[str, NodeStatus]:
        return {name: NodeStatus(list(shards), "", 0, []) for name, shards in self._shards.items()}

    def missing(self) -> list[str]:
        return asyncio.run(self._missing())


@pytest.mark.parametrize(
    ("leases", "shards", "missing"),
    [
        ([lease("a", "a"), lease("b", "b")], {"a": "a", "b": "b"}, []),
        ([lease("a", "a"), lease("b", "b")], {"b": "b"}, ["a"]),
        ([lease("a", "a", expired_s=3.0), lease("b", "b")], {"b": "ab"}, ["a"]),  # just taken over
        ([lease("a", "a"), lease("b", "b")], {"b": "ab"}, ["a"]),
        ([lease("a", None), lease("b", "b")], {"b": "b"}, []),
    ],
)  # fmt: skip
def test_it_waits_until_it_knows_who_has_each_room(
    leases: list[LeaseRow], shards: dict[str, str], missing: list[str]
) -> None:
    assert Host(leases, **shards).missing() == missing


def test_a_node_that_cannot_record_takes_no_room_itself_and_stops_no_round_at_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    host = Host([])
    monkeypatch.setattr(host, "refusal", lambda: NOTHING)
    monkeypatch.setattr(PublicHost, "cannot_record", lambda _: Notice("not_writable", "Recordings cannot be written."))
    assert host.why_no_room() == "Recordings cannot be written."
    assert not host.cannot_record()
