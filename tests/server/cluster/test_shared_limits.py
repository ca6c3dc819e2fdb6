"""Limits of an address over several nodes: attacks that change nodes, a node that dies, a database that is away."""

import asyncio
import itertools
import os
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import psycopg
import pytest

from movingout.server.cluster.errors import DatabaseAway
from movingout.server.cluster.limit_store import LimitStore
from movingout.server.cluster.shared_limits import PRUNE_S, SharedLimits
from movingout.server.connection.other_nodes import RoomCount
from movingout.server.settings import LEASE_S, Limits
from tests.database import PostgresServer
from tests.server.cluster.clock import SQL, TestClock, identity
from tests.server.cluster.nodes import host, node
from tests.server.cluster.processes import wait_until
from tests.server.live import ADMIN, Live, limits

ROOM = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]}
ATTACKER, OTHER = "192.0.2.7", "192.0.2.8"
FEW = Limits(rooms_per_address_per_minute=3, wrong_tokens_per_minute=3, recorded_per_address_per_day=1e6)


class Database(LimitStore):
    """One that a test takes away, and that counts what it is asked."""

    away, asked = False, 0

    async def _call(self, work: Any, within_s: float = 0.0) -> Any:
        self.asked += 1
        if self.away:
            raise DatabaseAway("the database does not answer")
        return await super()._call(work, within_s)


class Node:
    """The limits of a node, without a node; `rooms` are what it has."""

    def __init__(self, clock: TestClock, name: str) -> None:
        self.who, self.clock = identity(name), clock
        self.rooms: dict[str, RoomCount] = {}
        self.database = Database(clock.url, now=SQL, call_s=20.0)
        self.limits = SharedLimits(self.who.run, self.database, FEW, lambda: self.rooms, clock)

    async def start(self) -> None:
        nodes = self.clock.store()
        await nodes.prepare()
        assert await nodes.join(self.who)
        secret = await nodes.secret()
        await nodes.close()
        self.limits.begin(secret)

    async def renew(self) -> None:
        nodes = self.clock.store()
        await nodes.renew(self.who, {}, {}, shared=True, state="serving")
        await nodes.close()


async def two(clock: TestClock) -> tuple[Node, Node]:
    nodes = Node(clock, "a"), Node(clock, "b")
    for each in nodes:
        await each.start()
    return nodes


async def closed(*nodes: Node) -> None:
    for each in nodes:
        await each.limits.close()


def test_nodes_count_rooms_wrong_keys_and_bytes_together(clock: TestClock) -> None:
    async def run() -> None:
        a, b = await two(clock)
        assert [await each.limits.may_guess("x", "seat") for each in (a, b, a, b)] == [True, True, True, False]
        assert await b.limits.may_guess("x", "admin") and await b.limits.may_guess("y", "seat")
        a.rooms = {"x": RoomCount(4, 1)}
        await a.limits.share()
        assert await b.limits.may_open_room("x") == RoomCount(4, 1)
        assert await b.limits.may_open_room("y") == RoomCount(0, 0)
        found = [await each.limits.may_open_room("z") for each in (a, b, a, b)]
        assert found == [RoomCount(0, 0), RoomCount(1, 1), RoomCount(1, 1), None]
        a.limits.recorded("w", 950_000)
        await a.limits.share()
        assert not await b.limits.may_record("w") and await b.limits.may_record("v")
        await closed(a, b)

    asyncio.run(run())


def test_a_refused_opening_and_closed_rooms_count_until_the_next_second(clock: TestClock) -> None:
    async def run() -> None:
        a, b = await two(clock)
        assert await a.limits.may_open_room("x") == RoomCount(0, 0)
        assert await b.limits.may_open_room("x") == RoomCount(1, 1)
        await a.limits.share()
        assert await b.limits.may_open_room("x") == RoomCount(0, 0)
        await closed(a, b)

    asyncio.run(run())


def test_the_database_is_told_of_changes_alone_and_old_rows_are_deleted(clock: TestClock) -> None:
    async def run() -> None:
        a, b = await two(clock)
        a.rooms = {"x": RoomCount(1, 0)}
        await a.limits.share()
        asked = a.database.asked
        for _ in range(5):
            await a.limits.share()
        assert a.database.asked == asked
        await a.limits.may_guess("x", "seat")
        clock.advance(PRUNE_S + 1)
        await a.limits.share()
        with psycopg.connect(clock.url) as connection:
            assert connection.execute("SELECT * FROM movingout_cluster.address_rate").fetchall() == []
            assert [row[1:] for row in connection.execute("SELECT * FROM movingout_cluster.address_rooms")] == [
                (a.who.run, 1, 0)
            ]
        await closed(a, b)

    asyncio.run(run())


def test_the_database_does_not_read_whose_address_it_is(clock: TestClock) -> None:
    async def run() -> None:
        a, b = await two(clock)
        await a.limits.may_open_room(ATTACKER)
        with psycopg.connect(clock.url) as connection:
            tables = [connection.execute(f"SELECT * FROM movingout_cluster.address_{each}".encode()).fetchall()
                      for each in ("rate", "rooms")]  # fmt: skip
        assert all(tables) and ATTACKER not in str(tables)
        await closed(a, b)

    asyncio.run(run())


def test_the_rooms_of_a_dead_node_count_no_more_after_its_lease(clock: TestClock) -> None:
    async def run() -> None:
        a, b = await two(clock)
        a.rooms = {"x": RoomCount(9, 9)}
        await a.limits.share()
        clock.advance(LEASE_S - 1)
        await b.renew()
        assert await b.limits.may_open_room("x") == RoomCount(9, 9)
        clock.advance(1.1)
        assert await b.limits.may_open_room("x") == RoomCount(0, 0)
        await a.renew()  # it only hung
        assert await b.limits.may_open_room("x") == RoomCount(9, 9)
        await closed(a, b)

    asyncio.run(run())


def test_while_the_database_is_away_nobody_waits_for_it_and_afterwards_everything_is_told(
    clock: TestClock, caplog: pytest.LogCaptureFixture
) -> None:
    async def run() -> None:
        a, b = await two(clock)
        a.rooms = {"x": RoomCount(2, 2)}
        await a.limits.share()
        a.database.away, asked = True, a.database.asked
        assert await a.limits.may_open_room("x") == RoomCount(0, 0)
        assert [await a.limits.may_guess("x", "seat") for _ in range(9)] == [True] * 9
        assert a.database.asked == asked + 1, "only the first one has asked"
        a.rooms = {"x": RoomCount(3, 0)}
        a.limits.recorded("w", 950_000)
        await a.limits.share()
        a.database.away = False
        await a.limits.share()
        assert await b.limits.may_open_room("x") == RoomCount(3, 0)
        assert not await b.limits.may_record("w") and await b.limits.may_record("v")
        assert not [await a.limits.may_guess("x", "seat") for _ in range(4)][-1]
        told = [record.message for record in caplog.records]
        assert [text.partition(";")[0] for text in told] == [
            "the database does not answer",
            "limits of addresses hold for all nodes together again",
        ]
        await closed(a, b)

    asyncio.run(run())


# ---- two whole nodes, and somebody who changes between them -----------------------------------------------------


def ready(*nodes: Live) -> None:
    wait_until(lambda: all(each.call("/readyz")[0] == 200 for each in nodes), "the nodes take rooms")


def open_room(live: Live, address: str) -> int:
    return live.call("/api/rooms", ROOM, **{"X-Forwarded-For": address})[0]


@pytest.mark.slow
def test_an_address_that_opens_rooms_at_both_nodes_gets_no_more_than_at_one(tmp_path: Path, database: str) -> None:
    fewer = {"limits": limits(unjoined_rooms_per_address=4), "trusted_proxies": ("127.0.0.1",)}
    with node(tmp_path, database, "a", **fewer) as a, node(tmp_path, database, "b", **fewer) as b:
        ready(a, b)
        turns = itertools.islice(itertools.cycle((a, b)), 8)
        assert [open_room(each, ATTACKER) for each in turns] == [200] * 4 + [429] * 4
        assert len(a.rooms) + len(b.rooms) == 4
        assert open_room(b, OTHER) == 200
        for room in a.rooms:
            assert a.call(f"/api/admin/rooms/{room.id}/close", {}, token=ADMIN)[0] == 200
        wait_until(lambda: open_room(b, ATTACKER) == 200, "b hears of the closed rooms")


def test_wrong_keys_at_both_nodes_lock_the_address_as_at_one(tmp_path: Path, database: str) -> None:
    fewer = {"limits": limits(wrong_tokens_per_minute=4), "trusted_proxies": ("127.0.0.1",)}
    with node(tmp_path, database, "a", **fewer) as a, node(tmp_path, database, "b", **fewer) as b:

        def guess(live: Live, address: str = ATTACKER) -> int:
            return live.call("/api/admin/state", token="wrong", **{"X-Forwarded-For": address})[0]

        turns = itertools.islice(itertools.cycle((a, b)), 8)
        assert [guess(each) for each in turns] == [403] * 4 + [429] * 4
        assert guess(a, OTHER) == 403


@pytest.mark.slow
def test_without_the_database_a_round_goes_on_and_rooms_open_by_the_limits_of_the_node(
    tmp_path: Path, database_server: PostgresServer
) -> None:
    fewer = {"limits": limits(unjoined_rooms_per_address=2), "trusted_proxies": ("127.0.0.1",)}
    with node(tmp_path, database_server.new_database(), "a", **fewer) as a:
        ready(a)
        room = a.open_room("here", "idle", limit_ticks=100)
        person = a.person(room["room"], tokens=room["tokens"][:1])
        person.say(type="ready", seat=0, ready=True)
        person.play(5)
        os.kill(database_server.pid, signal.SIGSTOP)
        backends = stopped_backends(database_server)
        try:
            with ThreadPoolExecutor() as others:
                opened = others.submit(lambda: [open_room(a, ATTACKER) for _ in range(3)])
                while not opened.done():
                    person.play(1)
            assert opened.result() == [200, 200, 429]
        finally:
            for pid in (database_server.pid, *backends):
                os.kill(pid, signal.SIGCONT)
        wait_until(lambda: not host(a).node.problem, "the database answers again")
        ticks = [bundle.tick for bundle in person.bundles]
        assert ticks == list(range(1, len(ticks) + 1))


def stopped_backends(server: PostgresServer) -> list[int]:
    """Stop every process of the server that answers a connection."""
    import psutil

    children = [child.pid for child in psutil.Process(server.pid).children()]
    for pid in children:
        os.kill(pid, signal.SIGSTOP)
    return children
