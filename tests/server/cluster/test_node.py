"""One node: what it does with its leases as time passes and others come and go."""

import asyncio
from pathlib import Path

import psycopg
import pytest

from movingout.server.cluster import joining
from movingout.server.cluster.app import create_cluster_app
from movingout.server.cluster.errors import DatabaseAway, NodeRefused
from movingout.server.cluster.lease_store import FORGET_S, NodeIdentity
from movingout.server.cluster.node import ROUTED_S, SPARE
from movingout.server.cluster.report import tokens_apart, waiting_rooms
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.persistence.data_folder import exclusive_data_folder
from movingout.server.settings import LEASE_S, Settings
from tests.database import PostgresServer
from tests.server.cluster.clock import TestClock, identity
from tests.server.cluster.nodes import Node, together


def test_a_node_has_a_home_shard_and_waits_until_the_proxy_knows_it(clock: TestClock) -> None:
    async def story() -> None:
        a = await Node(clock, "a").start()
        home = a.node.home
        assert a.rooms.done == [f"open {home}.1"] and a.node.serves(home) and not a.node.takes_rooms
        clock.advance(ROUTED_S + 0.1)
        assert a.node.takes_rooms
        b = await Node(clock, "b").start()
        assert b.node.home != home

    together(story)


def test_the_rooms_of_a_node_that_is_gone_go_on_at_another_and_the_shard_is_given_back(clock: TestClock) -> None:
    async def story() -> None:
        a, b, c = [await Node(clock, name).start() for name in "abc"]
        a.rooms.counts = b.rooms.counts = c.rooms.counts = {a.node.home: 7}  # what lies on the disk
        for _ in range(3):  # that they share a folder is told twice: first to a itself, then to the others
            for each in (a, b, c):
                await each.step()
            clock.advance(1)
        home = a.node.home
        for _ in range(round(LEASE_S) + 2):
            await b.step()
            await c.step()
            clock.advance(1)
        took = [each for each in (b, c) if home in each.node.open_shards]
        assert len(took) == 1 and f"open {home}.2" in took[0].rooms.done
        assert not a.node.serves(home)
        await a.step()
        assert a.rooms.done[-1] == f"open {a.node.home}.1" and a.node.home != home  # and a goes on with another
        assert f"close {home}" in a.rooms.done
        took[0].rooms.counts.clear()
        await took[0].step()
        assert took[0].rooms.done[-1] == f"forget {home}.2" and home not in took[0].node.leases

    together(story)


def test_without_a_shared_folder_rooms_wait_for_their_node_and_it_is_said_which(clock: TestClock) -> None:
    async def story() -> None:
        a, b = await Node(clock, "a", folder="one").start(), await Node(clock, "b", folder="two").start()
        assert tokens_apart(a.node.view, a.node.who) == "", "it was alone when it started"
        assert tokens_apart(b.node.view, b.node.who).startswith("the data folder of a is another one, with an admin")
        home = a.node.home
        a.rooms.counts[home] = 1
        for _ in range(3):
            await a.step()
            await b.step()
        clock.advance(30)
        await b.step()
        assert home not in b.node.leases and b.node.comes_back_soon(home) is False
        assert list(waiting_rooms(b.node.view, b.node.store.lease_s)) == [
            f"node a has been away for 25 s: 1 room waits for it (ids beginning with {home})"
        ]
        assert a.node.serves(home)  # it may go on without the database: nobody else can
        again = await Node(clock, "a", run="again", folder="one").start()
        assert again.node.home == home and again.rooms.done == [f"open {home}.2"]

    together(story)


def test_what_no_node_has_is_taken_at_the_start_and_after_a_look(clock: TestClock) -> None:
    async def story() -> None:
        a = Node(clock, "a")
        a.rooms.on_disk = frozenset("fr")  # of a server that was no node, or of another database
        await a.start()
        assert sorted(a.rooms.done) == ["open f.1", "open r.1"] and a.node.home in "fr"
        b = await Node(clock, "b", folder="elsewhere").start()
        a.rooms.on_disk = frozenset(SHARDS)
        await a.step()
        assert set(a.node.leases) == {a.node.home}, "looks once a minute; the other one has nothing and is given back"
        await b.step()
        await a.node.look()
        await a.step()
        assert b.node.home not in a.node.leases, "another node has it"
        assert len(SHARDS) - len([*a.node.leases, *b.node.leases]) == SPARE, "nodes find a shard still"

    together(story)


def test_a_disk_that_hangs_costs_no_lease(clock: TestClock) -> None:
    async def story() -> None:
        a, hangs = Node(clock, "a"), asyncio.Event()
        await a.start()

        async def shards_on_disk() -> frozenset[str]:
            await hangs.wait()
            return frozenset("fr")

        a.rooms.shards_on_disk = shards_on_disk  # type: ignore[method-assign]
        look = asyncio.create_task(a.node.look())
        for _ in range(100):
            clock.advance(1.0)
            await asyncio.wait_for(a.step(), 5.0)
            assert a.node.serves(a.node.home)
        hangs.set()
        await look
        await a.step()
        assert {"f", "r"} - {a.node.home} <= {each[5] for each in a.rooms.done if each.startswith("open")}

    together(story)


def test_no_lease_ends_while_a_node_that_starts_looks_at_the_disk(clock: TestClock) -> None:
    async def story() -> None:
        home = (await Node(clock, "a").start()).node.home
        await Node(clock, "b").start()
        clock.advance(2 * LEASE_S)
        again = Node(clock, "a", run="again")

        async def slowly() -> frozenset[str]:
            clock.advance(2 * LEASE_S)
            return frozenset()

        again.rooms.shards_on_disk = slowly  # type: ignore[method-assign]
        await again.start()
        assert again.node.home == home and again.node.serves(home)

    together(story)


@pytest.mark.parametrize("alone", [True, False])
def test_a_node_takes_its_rooms_again_whose_lease_was_longer_than_it_waits_for(clock: TestClock, alone: bool) -> None:
    async def story() -> None:
        a = Node(clock, "a")
        a.node.store.lease_s = 60.0
        await a.start()
        others = [] if alone else [await Node(clock, name).start() for name in "bcd"]
        home = a.node.home
        a.rooms.counts = {home: 1}
        for each in (a, *others, a):
            await each.step()
        again = await Node(clock, "a", run="again").start()
        assert again.node.home != home and home not in again.node.leases, "the lease lasts"
        again.rooms.counts = {home: 1}
        for _ in range(60):
            for each in (*others, again):  # the others look first, and leave it to its node
                await each.step()
            clock.advance(1.0)
        assert again.node.serves(home) and f"open {home}.2" in again.rooms.done
        assert list(waiting_rooms(again.node.view, LEASE_S)) == []

    together(story)


def test_a_node_does_not_start_beside_those_of_another_database(
    database_server: PostgresServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joining, "STARTING_S", 0)
    one, other = database_server.new_database(), database_server.new_database()

    def start(name: str, database: str) -> None:
        create_cluster_app(Settings(data=tmp_path, cluster=database, node=name))

    with exclusive_data_folder(tmp_path / "nodes" / "a"):
        start("a", one)
        with pytest.raises(NodeRefused, match=r"nodes of another cluster use the data folder .* \(a\): end all"):
            start("b", other)
        start("b", one)
    start("b", other)  # a has ended


def test_while_the_database_is_away_shared_rooms_wait_and_then_go_on_here(
    clock: TestClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def story() -> None:
        a, b = await Node(clock, "a").start(), await Node(clock, "b").start()
        for _ in range(3):
            await a.step()
            await b.step()
        home = a.node.home
        clock.advance(LEASE_S)
        assert not a.node.serves(home)
        a.node._close_lapsed()
        assert a.rooms.done[-1] == f"close {home}" and a.node.home == home
        await a.step()  # before b has looked
        assert a.node.serves(home) and a.rooms.done[-1] == f"open {home}.1"

    together(story)


def test_the_loop_of_a_node_outlives_a_database_that_is_away(
    clock: TestClock, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def story() -> None:
        a = await Node(clock, "a").start()
        away = [True, True, False]

        async def step() -> None:
            if away.pop(0):
                raise DatabaseAway("the database x does not answer: gone")
            a.node._say("")
            raise asyncio.CancelledError

        monkeypatch.setattr(a.node, "step", step)
        with pytest.raises(asyncio.CancelledError):
            await a.node._run()

    together(story)
    said = [record.getMessage() for record in caplog.records]
    assert len([line for line in said if "does not answer: gone" in line]) == 1  # once, not every second
    assert said[-1] == "the database answers again"


def test_a_node_that_leaves_while_it_renews_its_leases_has_left(clock: TestClock) -> None:
    """The rest of the renewal came after the end, and said that the node serves still."""

    async def story() -> None:
        a = await Node(clock, "a").start()
        with psycopg.connect(clock.url) as other:
            other.execute("SELECT FROM movingout_cluster.lease FOR UPDATE")  # so that the renewal takes a while
            a.node.begin()
            await waits_for_a_lock(clock)
            leaving = asyncio.create_task(a.node.leave())
            await asyncio.sleep(0.1)
            other.commit()
            await leaving
        await asyncio.sleep(0.1)
        store = clock.store()
        view = await store.view()
        await store.close()
        home = view.lease(a.node.home)
        assert [node.state for node in view.nodes] == ["ended"]
        assert home is not None and home.expired_s >= 0.0

    together(story)


async def waits_for_a_lock(clock: TestClock) -> None:
    with psycopg.connect(clock.url, autocommit=True) as connection:
        while not connection.execute("SELECT FROM pg_locks WHERE NOT granted").fetchall():
            await asyncio.sleep(0.01)


def test_files_that_are_not_there_are_not_taken_over(clock: TestClock) -> None:
    async def story() -> None:
        a, b = await Node(clock, "a").start(), await Node(clock, "b").start()
        for _ in range(3):
            await a.step()
            await b.step()
        b.rooms.visible = False
        clock.advance(2 * LEASE_S)
        await b.step()
        assert a.node.home not in b.node.leases

    together(story)


def test_a_node_that_does_not_fit_is_refused_with_a_sentence(clock: TestClock) -> None:
    async def story() -> None:
        a = await Node(clock, "a").start()
        a.rooms.counts[a.node.home] = 1
        await a.step()
        with pytest.raises(NodeRefused, match=r"version 2\.0.*a: 1\.0.*end these first"):
            await Node(clock, "b", format="2", version="2.0").start()
        with pytest.raises(NodeRefused, match=r"something else than the running nodes \(a\).*study file and options"):
            await Node(clock, "b", format="2").start()
        with pytest.raises(NodeRefused, match="rooms of node a lie in another data folder"):
            await Node(clock, "a", run="other", folder="elsewhere").start()
        a.node.who = identity("a")

        other = Node(clock, "a", run="other")
        join = other.node.store.join

        async def join_while_a_lives(who: NodeIdentity) -> bool:
            await a.step()
            return await join(who)

        other.node.store.join = join_while_a_lives  # type: ignore[method-assign]
        with pytest.raises(NodeRefused, match="a node a is running already"):
            await other.start()

    together(story)


def test_one_node_runs_the_study_and_another_one_after_it(clock: TestClock) -> None:
    async def story() -> None:
        a, b = [await Node(clock, name, study=True).start() for name in "ab"]
        for each in (a, b, a, b):
            await each.step()
        assert a.node.serves(STUDY) and "open study.1" in a.rooms.done and STUDY not in b.node.leases
        clock.advance(LEASE_S - 1)
        await b.step()
        assert STUDY not in b.node.leases, "the lease lasts"
        clock.advance(1.5)
        assert not a.node.serves(STUDY), "a does not act for the study, although nobody has told it anything"
        await b.step()
        assert b.node.serves(STUDY) and "open study.2" in b.rooms.done
        await a.step()
        assert a.rooms.done[-1] != "open study.3" and STUDY not in a.node.leases

    together(story)


def test_nodes_of_games_leave_the_study_alone_and_a_draining_node_does_not_take_it(clock: TestClock) -> None:
    async def story() -> None:
        game = await Node(clock, "game").start()
        await game.step()
        ending = await Node(clock, "ending", study=True).start()
        ending.node.state = "draining"
        await ending.step()
        assert STUDY not in game.node.leases and STUDY not in ending.node.leases

    together(story)


def test_the_nodes_of_a_study_share_a_folder(clock: TestClock) -> None:
    async def story() -> None:
        await Node(clock, "a", study=True, folder="one").start()
        with pytest.raises(NodeRefused, match=r"share one data folder.*another one than a"):
            await Node(clock, "b", study=True, folder="two").start()

    together(story)


def test_nodes_that_are_gone_for_a_day_are_forgotten_unless_rooms_wait_for_them(clock: TestClock) -> None:
    async def story() -> None:
        waited, gone = [await Node(clock, name, folder=name).start() for name in ("waited", "gone")]
        waited.rooms.counts[waited.node.home] = 1
        for each in (waited, gone):
            await each.step()
        clock.advance(FORGET_S + 10)
        await Node(clock, "new").start()
        view = await gone.node.store.view()
        assert [node.name for node in view.nodes] == ["new", "waited"]

    together(story)
