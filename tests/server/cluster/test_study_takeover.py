"""When a node begins the study, and what becomes of it when that fails."""

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from movingout.server.cli import main
from movingout.server.cluster.commands import cluster
from movingout.server.cluster.errors import NodeEnds
from movingout.server.cluster.held_leases import HeldLeases
from movingout.server.cluster.lease_store import ClusterView, LeaseRow, NodeRow
from movingout.server.cluster.open_shards import OpenShards
from movingout.server.cluster.report import unserved_study
from movingout.server.cluster.shards import STUDY
from movingout.server.cluster.study.host import StudyNodeHost
from movingout.server.cluster.study.room_works import NodeStatus
from movingout.server.cluster.study_tries import PAUSE_S, TRIES, StudyTries
from movingout.server.notices import NOTHING, Notice
from movingout.server.public_host import PublicHost
from movingout.server.settings import Settings
from movingout.study.errors import StoreError
from tests.server.cluster.clock import TestClock
from tests.server.cluster.nodes import FakeRooms, Node, together

START = "to go on with it, start a node: movingout study serve FILE --cluster URL --node NAME"
WHY = "the study cannot begin here: the database x does not answer"


def lease(shard: str, node: str | None, expired_s: float = -5.0) -> LeaseRow:
    return LeaseRow(shard, 1, node, "run", "folder", "format", True, 1, expired_s)


class Host(StudyNodeHost):
    """Node b, which knows `leases` from the database and where other nodes say that their rooms are."""

    stopping = False

    def __init__(self, leases: list[LeaseRow], **shards: str) -> None:
        view = ClusterView(tuple(leases), ())
        self.node = cast(Any, SimpleNamespace(view=view, comes_back_soon=lambda shard: True, now=lambda: 0.0))
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


def test_a_node_that_ends_does_not_wait_for_the_rooms_of_others_to_begin_the_study() -> None:
    host = Host([lease("a", "a")])
    host.stopping = True
    with pytest.raises(NodeEnds):
        asyncio.run(asyncio.wait_for(host._all_there(), 0.5))


def test_a_node_that_ends_while_the_last_rooms_are_found_does_not_begin_the_study(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Nobody would have ended it. Nor is it a fault of the node that it does not."""

    class Ending(Host):
        async def _missing(self) -> list[str]:
            self.stopping = True
            return []

    async def begin() -> None:
        leases, tries = HeldLeases(), StudyTries()
        leases.taken(STUDY, fence=1, asked_at=0.0)
        shards = OpenShards(Ending([]), leases, tries, lambda: 0.0)
        shards.open_all()
        await shards.settled()
        assert STUDY not in shards and tries.problem == ""

    asyncio.run(begin())
    assert not caplog.records


class NoStudy(FakeRooms):
    """A node whose study cannot be begun."""

    broken = True

    async def open_shard(self, shard: str, fence: int) -> None:
        await super().open_shard(shard, fence)
        if shard == STUDY and self.broken:
            raise StoreError("the database x\ndoes not answer")


def test_after_some_attempts_it_is_the_turn_of_others_and_then_again_of_this_node() -> None:
    tries = StudyTries()
    for _ in range(TRIES):
        assert not tries.used_up and tries.may_try(5.0)
        tries.failed("the database x\n does not answer")
    assert tries.used_up and tries.problem == WHY
    tries.given_back(5.0)
    assert not tries.used_up and not tries.may_try(5.0 + PAUSE_S - 0.1) and tries.may_try(5.0 + PAUSE_S)
    assert tries.problem == WHY, "until it is served somewhere"
    tries.went_well()
    assert tries.problem == ""


def test_a_node_that_cannot_begin_the_study_is_not_well(tmp_path: Path, clock: TestClock) -> None:
    host = StudyNodeHost(Settings(data=tmp_path, cluster=clock.url, node="a"), "a study")
    assert host.faults() == []
    host.node.study_tries.failed("the database x does not answer")
    assert host.faults() == [WHY] and WHY in host.why_not_ready()


def test_a_node_that_cannot_begin_the_study_leaves_it_to_another_one(clock: TestClock) -> None:
    async def story() -> None:
        a = await Node(clock, "a", study=True, rooms=NoStudy()).start()
        b = await Node(clock, "b", study=True).start()
        for _ in range(TRIES):
            await a.step()
            assert STUDY in a.node.leases and not a.node.serves(STUDY) and a.node.study_tries.problem == WHY
        await b.step()
        assert [row.problem for row in b.node.view.nodes] == [WHY, ""], "others know, too"
        await a.step()
        assert STUDY not in a.node.leases
        await b.step()
        assert b.node.serves(STUDY) and "open study.2" in b.rooms.done
        await a.step()
        assert a.node.study_tries.problem == WHY, "b has not said yet that it serves the study"
        await b.step()
        await a.step()
        assert a.node.study_tries.problem == ""

    together(story)


def test_a_node_that_drains_no_longer_says_that_the_study_cannot_begin_once_another_serves_it(clock: TestClock) -> None:
    async def story() -> None:
        a = await Node(clock, "a", study=True, rooms=NoStudy()).start()
        b = await Node(clock, "b", study=True).start()
        for _ in range(TRIES + 1):
            await a.step()
        assert STUDY not in a.node.leases and a.node.study_tries.problem == WHY
        a.node.state = "draining"
        for each in (b, b, a, a):
            await each.step()
        assert b.node.serves(STUDY) and a.node.study_tries.problem == ""
        assert [row.problem for row in a.node.view.nodes] == ["", ""]

    together(story)


def test_a_node_that_is_alone_goes_on_trying_to_begin_the_study(clock: TestClock) -> None:
    async def story() -> None:
        rooms = NoStudy()
        a = await Node(clock, "a", study=True, rooms=rooms).start()
        for _ in range(2 * TRIES):
            await a.step()
            assert a.node.leases.fence(STUDY) == 1 and a.node.study_tries.problem == WHY
            clock.advance(1.0)
        rooms.broken = False
        await a.step()
        assert a.node.serves(STUDY) and a.node.study_tries.problem == ""

    together(story)


def test_while_no_node_can_begin_the_study_all_say_so_without_a_break(clock: TestClock) -> None:
    async def story() -> None:
        nodes = [await Node(clock, name, study=True, rooms=NoStudy()).start() for name in "ab"]
        fences, complained = set[int](), set[str]()
        for _ in range(60):
            for each in nodes:
                await each.step()
                if each.node.study_tries.problem:
                    complained.add(each.node.who.name)
                assert bool(each.node.study_tries.problem) is (each.node.who.name in complained)
                fences |= {each.node.leases.fence(STUDY)} if STUDY in each.node.leases else set()
            clock.advance(1.0)
        assert complained == {"a", "b"} and len(fences) > 4, "they take turns"
        NoStudy.broken = False
        for _ in range(round(PAUSE_S) + 2):
            for each in nodes:
                await each.step()
            clock.advance(1.0)
        assert [each.node.study_tries.problem for each in nodes] == ["", ""]
        assert sum(each.node.serves(STUDY) for each in nodes) == 1

    try:
        together(story)
    finally:
        NoStudy.broken = True


def test_status_does_not_say_that_a_node_runs_a_study_which_it_cannot_begin(
    clock: TestClock, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    a = Node(clock, "a", study=True, rooms=NoStudy())

    async def story() -> None:
        await a.start()
        await a.step()
        await a.step()

    together(story)
    monkeypatch.setattr(cluster, "LeaseStore", lambda *_, **__: clock.store())
    assert main(["cluster", "status", "--cluster", clock.url]) == 1
    shown = capsys.readouterr().out
    assert f"node a: {WHY}" in shown and "runs the study" not in shown


def test_status_says_that_nobody_serves_the_study_whose_nodes_were_killed_not_ended(
    clock: TestClock, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "LeaseStore", lambda *_, **__: clock.store())

    def status() -> int:
        return main(["cluster", "status", "--cluster", clock.url])

    async def serve(ended: bool) -> None:
        a = await Node(clock, "a", run=str(ended), study=True).start()
        await a.step()
        await a.step()
        if ended:
            await a.node.store.leave(a.node.who)

    together(lambda: serve(ended=False))
    assert status() == 0
    clock.advance(120.0)
    capsys.readouterr()
    assert status() == 1
    assert f"nobody serves the study: node a had it last, 115 s ago; {START}" in capsys.readouterr().out
    together(lambda: serve(ended=True))
    assert status() == 0 and "nobody" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("expired_s", "ago"),
    [(-3.0, ""), (5.0, ", 5 s ago"), (119.4, ", 119 s ago"), (600.0, ", 10 min ago"), (9000.0, ", 2 h ago")],
)
def test_status_says_since_when_nobody_serves_the_study_and_what_to_do(expired_s: float, ago: str) -> None:
    def node(name: str, state: str, alive: bool = False, format: str = "format") -> NodeRow:
        return NodeRow(name, "folder", "0.1", format, "", state, 0, f"run of {name}", alive, seen_s=0.5)

    def said(*nodes: NodeRow, last: str | None = "a") -> str:
        return unserved_study(ClusterView((lease(STUDY, last, expired_s),), nodes))

    died = f"nobody serves the study: node a had it last{ago}; {START}"
    moments = "it is to go on within moments at b, or the log there says why it does not"
    assert said(node("a", "ended"), node("b", "serving")) == died, "b died long before, and nobody has noticed"
    assert said(node("a", "serving"), node("b", "ended")) == died
    assert said(node("a", "ended"), node("b", "draining", alive=True)) == died
    assert said(node("a", "ended"), node("b", "serving", alive=True)).endswith(f"{ago}; {moments}")
    given_back = said(node("b", "serving"), last=None)
    assert given_back == f"nobody serves the study: the node that had it last gave it back{ago}; {START}"
    assert said(node("a", "ended"), node("b", "ended")) == "", "somebody wanted it so"
    assert said(node("a", "ended"), node("b", "serving", format="of another study")) == ""


def test_a_node_that_cannot_record_takes_no_room_itself_and_stops_no_round_at_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    host = Host([])
    monkeypatch.setattr(host, "refusal", lambda: NOTHING)
    monkeypatch.setattr(PublicHost, "cannot_record", lambda _: Notice("not_writable", "Recordings cannot be written."))
    assert host.why_no_room() == "Recordings cannot be written."
    assert not host.cannot_record()
