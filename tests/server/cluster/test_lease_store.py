"""Leases in a real PostgreSQL: who gets which, and that no two nodes ever believe to have the same one."""

import asyncio
import json
import os
import signal
import socket
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

import psycopg
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from movingout.server.cli import main
from movingout.server.cluster.errors import ClusterError, DatabaseAway
from movingout.server.cluster.held_leases import HeldLeases
from movingout.server.cluster.lease_store import FORGET_S, LeaseRow, LeaseStore
from movingout.server.settings import LEASE_S
from tests.database import PostgresServer
from tests.server.cluster.clock import TestClock, identity

Answer = TypeVar("Answer")
A, B = identity("a"), identity("b")


async def row(store: LeaseStore, shard: str) -> LeaseRow:
    found = (await store.view()).lease(shard)
    assert found is not None
    return found


def test_a_lease_is_taken_renewed_lost_and_given_back(clock: TestClock) -> None:
    async def run() -> None:
        store = clock.store()
        await store.prepare()
        await store.prepare()  # the tables are there
        free = await row(store, "k")
        assert await store.take(A, free, shared=True) == 1
        assert await store.take(B, free, shared=True) is None  # it is not as it was seen
        assert await store.take(B, await row(store, "k"), shared=True) is None  # it lasts
        clock.advance(LEASE_S - 1)
        kept, view = await store.renew(A, {"k": 1, "m": 1}, {"k": 3}, shared=True, state="serving")
        assert kept == {"k"} and sum(lease.rooms for lease in view.leases) == 3
        clock.advance(LEASE_S - 1)
        assert await store.take(B, await row(store, "k"), shared=True) is None
        clock.advance(1)
        assert await store.take(B, await row(store, "k"), shared=True) == 2
        kept, _ = await store.renew(A, {"k": 1}, {}, shared=True, state="serving")
        assert kept == frozenset()
        await store.release(A, "k", 1)  # not its own any more
        assert (await row(store, "k")).node == "b"
        await store.release(B, "k", 2)
        assert (await row(store, "k")).node is None
        await store.close()

    asyncio.run(run())


def test_rooms_wait_for_their_node_unless_another_one_has_the_folder_and_the_format(clock: TestClock) -> None:
    async def run() -> None:
        store = clock.store()
        await store.prepare()
        await store.take(A, await row(store, "k"), shared=False)
        await store.take(A, await row(store, "m"), shared=True)
        clock.advance(LEASE_S + 1)
        alone, shared = await row(store, "k"), await row(store, "m")
        assert await store.take(B, alone, shared=True) is None
        assert await store.take(identity("b", folder="other"), shared, shared=True) is None
        assert await store.take(identity("b", format="2"), shared, shared=True) is None
        assert await store.take(B, shared, shared=True) == 2
        assert await store.take(identity("a", run="next"), alone, shared=True) == 2
        clock.advance(FORGET_S + 10)
        assert await store.take(identity("c", folder="other"), await row(store, "k"), shared=True) == 3
        await store.close()

    asyncio.run(run())


def test_a_name_is_for_one_node_until_it_is_silent_or_has_ended(clock: TestClock) -> None:
    async def run() -> None:
        store = clock.store()
        await store.prepare()
        again = identity("a", run="again")
        assert await store.join(A) and await store.join(A)
        assert not await store.join(again)
        await store.leave(A)
        assert await store.join(again)
        clock.advance(LEASE_S + 1)
        assert await store.join(A)
        await store.close()

    asyncio.run(run())


def test_of_many_that_take_the_same_lease_at_once_one_gets_it(clock: TestClock) -> None:
    async def prepared() -> LeaseRow:
        store = clock.store()
        await store.prepare()
        free = await row(store, "k")
        await store.close()
        return free

    free, got = asyncio.run(prepared()), list[int | None]()

    def take(number: int) -> None:
        async def run() -> None:
            store = clock.store()
            got.append(await store.take(identity(f"n{number}"), free, shared=True))
            await store.close()

        asyncio.run(run())

    threads = [threading.Thread(target=take, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(got, key=str) == [1] + [None] * 7


def test_the_address_must_be_one_of_postgresql() -> None:
    for wrong in ("sqlite:///x", "nonsense", "http://host/x"):
        with pytest.raises(ClusterError, match="postgresql://user@host/name"):
            LeaseStore(wrong)


def test_who_looks_at_a_database_without_nodes_is_told_so_and_makes_no_tables(
    database: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The status of a mistyped name was an empty table and exit code 0, and the database had two schemas more."""
    for _ in range(2):
        assert main(["cluster", "status", "--cluster", database]) == 2
        assert "no node was ever started with the database postgresql://" in capsys.readouterr().err

    async def prepare() -> None:
        store = LeaseStore(database)
        await store.prepare()
        await store.close()

    asyncio.run(prepare())
    assert main(["cluster", "status", "--cluster", database]) == 0


def test_status_counts_silence_by_the_lease_that_nodes_were_started_with(
    database: str, capsys: pytest.CaptureFixture[str]
) -> None:
    async def join() -> None:
        store = LeaseStore(database, lease_s=30.0)
        await store.prepare()
        await store.join(identity("a"))
        await store.close()

    def state(*words: str) -> str:
        assert main(["cluster", "status", "--cluster", database, "--json", *words]) == 0
        return str(json.loads(capsys.readouterr().out)["nodes"][0]["state"])

    asyncio.run(join())
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute("UPDATE movingout_cluster.node SET seen = seen - interval '10 seconds'")
    assert (state("--lease", "30"), state()) == ("serving", "away")


def test_a_database_that_is_away_is_a_sentence() -> None:
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    store = LeaseStore(f"postgresql://tester:secret@127.0.0.1:{port}/x")
    with pytest.raises(DatabaseAway, match="does not answer") as told:
        asyncio.run(store.view())
    assert "secret" not in str(told.value)


def test_a_database_that_hangs_is_given_up_and_answers_again(database_server: PostgresServer, database: str) -> None:
    import psycopg

    async def run() -> None:
        store = LeaseStore(database)
        await store.prepare()
        with psycopg.connect(database) as other:
            pid = other.execute(
                "SELECT pid FROM pg_stat_activity WHERE application_name = 'movingout cluster' AND datname = %s",
                (database.rsplit("/", 1)[1],),
            ).fetchone()
        assert pid
        os.kill(pid[0], signal.SIGSTOP)
        try:
            with pytest.raises(DatabaseAway, match="in time"):
                await store.view()
            assert len((await store.view()).leases) == 33  # on another connection
        finally:
            os.kill(pid[0], signal.SIGCONT)
        await store.close()

    asyncio.run(run())


class Leases(RuleBasedStateMachine):
    """Three nodes that renew, take over, hang and lose the database in any order; questions and answers take time."""

    url = ""

    def __init__(self) -> None:
        super().__init__()
        self.clock = TestClock(self.url)
        self.loop = asyncio.new_event_loop()
        self.store = self.clock.store()
        self.run(self.store.prepare())
        self.clock.forget_leases()
        self.nodes = {name: HeldLeases() for name in "abc"}
        for leases in self.nodes.values():
            leases.shared = True
        self.fences: list[int] = []

    def run(self, call: Coroutine[Any, Any, Answer]) -> Answer:
        return self.loop.run_until_complete(call)

    names = st.sampled_from("abc")
    delays = st.sampled_from([0.0, 0.2, 1.4, 3.0])

    @rule(name=names, before=delays, after=delays, answered=st.booleans())
    def renew(self, name: str, before: float, after: float, answered: bool) -> None:
        asked_at, leases = self.clock.now, self.nodes[name]
        self.clock.advance(before)
        kept, _ = self.run(self.store.renew(identity(name), leases.fences, {}, shared=True, state="serving"))
        self.clock.advance(after)
        if answered:
            leases.renewed(kept, asked_at)

    @rule(name=names, before=delays, after=delays, answered=st.booleans())
    def take(self, name: str, before: float, after: float, answered: bool) -> None:
        asked_at, seen = self.clock.now, self.run(row(self.store, "k"))
        self.clock.advance(before)
        fence = self.run(self.store.take(identity(name), seen, shared=True))
        self.clock.advance(after)
        if fence is not None:
            self.fences.append(fence)
            if answered:
                self.nodes[name].taken("k", fence, asked_at)

    @rule(name=names)
    def release(self, name: str) -> None:
        leases = self.nodes[name]
        if "k" in leases:
            fence = leases.fence("k")
            leases.dropped("k")
            self.run(self.store.release(identity(name), "k", fence))

    @rule(seconds=st.sampled_from([0.1, 1.0, LEASE_S, 60.0]))
    def time_passes(self, seconds: float) -> None:
        self.clock.advance(seconds)

    @invariant()
    def no_two_nodes_believe_to_have_it(self) -> None:
        owners = [name for name, leases in self.nodes.items() if leases.valid("k", self.clock.now)]
        assert len(owners) <= 1
        if owners:  # and the database agrees
            found = self.run(row(self.store, "k"))
            assert (found.node, found.fence) == (owners[0], self.nodes[owners[0]].fence("k"))

    @invariant()
    def fencing_tokens_only_grow(self) -> None:
        assert self.fences == sorted(set(self.fences))

    def teardown(self) -> None:
        self.run(self.store.close())
        self.loop.close()
        self.clock.close()


@pytest.mark.slow
def test_no_two_nodes_ever_own_one_room(database: str) -> None:
    Leases.url = database
    many = settings(
        max_examples=40, stateful_step_count=25, deadline=None, suppress_health_check=[*HealthCheck], database=None
    )
    run_state_machine_as_test(Leases, settings=many)
