"""What addresses have used at all nodes, in a real PostgreSQL."""

import asyncio
import threading
from collections.abc import Iterator

import pytest

from movingout.server.cluster.limit_store import RECORDED, Rate
from movingout.server.connection.other_nodes import RoomCount
from movingout.server.settings import LEASE_S
from tests.server.cluster.clock import TestClock, identity

A, B = identity("a"), identity("b")
MANY = Rate(100.0, 100.0)
BYTES = Rate(per_s=10.0, burst=1000.0)


@pytest.fixture
def clock(database: str) -> Iterator[TestClock]:
    clock = TestClock(database)
    asyncio.run(joined(clock))
    yield clock
    clock.close()


async def joined(clock: TestClock) -> None:
    """Two nodes that are alive."""
    nodes = clock.store()
    await nodes.prepare()
    assert await nodes.join(A) and await nodes.join(B)
    await nodes.close()


async def renewed(clock: TestClock) -> None:
    """Node b is still alive."""
    nodes = clock.store()
    await nodes.renew(B, {}, {}, shared=True, state="serving")
    await nodes.close()


def count(clock: TestClock, table: str) -> int:
    import psycopg

    with psycopg.connect(clock.url) as connection:
        row = connection.execute(f"SELECT count(*) FROM movingout_cluster.{table}".encode()).fetchone()
    return int(row[0]) if row else 0


def test_a_bucket_is_emptied_by_all_nodes_and_filled_by_the_clock_of_the_database(clock: TestClock) -> None:
    async def run() -> None:
        one, other, rate = clock.limits(), clock.limits(), Rate(per_s=0.5, burst=4.0)
        taken = [await store.take("key", "x", rate) for store in (one, other, one, other, one, other)]
        assert taken == [True, True, True, True, False, False]
        assert await one.take("key", "y", rate) and await one.take("another", "x", rate)
        clock.advance(2.0)
        assert [await other.take("key", "x", rate) for _ in range(2)] == [True, False]
        clock.advance(60.0)
        assert [await one.take("key", "x", rate) for _ in range(5)] == [True] * 4 + [False]
        clock.advance(60.0)
        await one.prune()
        assert count(clock, "address_rate") == 0
        await one.close()
        await other.close()

    asyncio.run(run())


def test_bytes_of_all_nodes_fill_a_day(clock: TestClock) -> None:
    async def run() -> None:
        store = clock.limits()
        await store.publish(A.run, {}, {"x": 600, "y": 100}, BYTES)
        assert await store.has(RECORDED, "x", BYTES, 400)
        await store.publish(B.run, {}, {"x": 600}, BYTES)  # more than there was
        assert not await store.has(RECORDED, "x", BYTES, 1) and await store.has(RECORDED, "y", BYTES, 900)
        clock.advance(10.0)
        assert await store.has(RECORDED, "x", BYTES, 99) and not await store.has(RECORDED, "x", BYTES, 101)
        await store.close()

    asyncio.run(run())


def test_rooms_of_other_nodes_count_until_they_are_closed_or_their_node_is_gone(clock: TestClock) -> None:
    async def run() -> None:
        store = clock.limits()

        async def elsewhere() -> RoomCount | None:
            return await store.open_room(B.run, "x", RoomCount(1, 1), MANY)

        await store.publish(A.run, {"x": RoomCount(3, 2), "y": RoomCount(5, 5)}, {}, BYTES)
        assert await elsewhere() == RoomCount(3, 2), "its own are not counted"
        await store.publish(A.run, {"x": RoomCount(4, 0)}, {}, BYTES)
        assert await elsewhere() == RoomCount(4, 0)
        await store.publish(A.run, {"x": RoomCount()}, {}, BYTES)
        assert await elsewhere() == RoomCount(0, 0)
        await store.publish(A.run, {"x": RoomCount(7, 7)}, {}, BYTES)
        clock.advance(LEASE_S + 0.1)
        await renewed(clock)
        assert await elsewhere() == RoomCount(0, 0), "node a is dead"
        await store.close()

    asyncio.run(run())


def test_rooms_of_a_run_that_is_over_are_deleted(clock: TestClock) -> None:
    async def run() -> None:
        store, nodes = clock.limits(), clock.store()
        for who in (A, B):
            await store.publish(who.run, {"x": RoomCount(1, 1)}, {}, BYTES)
        await nodes.leave(A)
        assert await store.open_room(B.run, "x", RoomCount(1, 1), MANY) == RoomCount(0, 0)
        await store.prune()
        assert count(clock, "address_rooms") == 1
        await nodes.close()
        await store.close()

    asyncio.run(run())


def test_of_many_nodes_that_open_rooms_at_once_no_more_get_one_than_there_may_be(clock: TestClock) -> None:
    limit, got = 5, list[bool]()
    start = threading.Barrier(12)

    def open_one(number: int) -> None:
        async def run() -> None:
            nodes, store, who = clock.store(), clock.limits(), identity(f"n{number}")
            assert await nodes.join(who)
            await asyncio.to_thread(start.wait)
            found = await store.open_room(who.run, "x", RoomCount(1, 1), MANY)
            assert found is not None
            got.append(1 + found.open <= limit)
            await nodes.close()
            await store.close()

        asyncio.run(run())

    threads = [threading.Thread(target=open_one, args=(number,)) for number in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(got) == [False] * 7 + [True] * 5
