"""When a server collects garbage, and how many files it may open."""

import gc
import resource

import pytest

from movingout.server.garbage_collection import (
    BUSY_S,
    GROWTH_OBJECTS,
    IDLE_S,
    GarbageCollection,
    objects_since_collection,
)
from movingout.server.open_files import raise_open_files
from movingout.server.settings import Limits


class Measured:
    """A clock and a number of objects that change when told to."""

    now = 0.0
    growth = 0

    def collection(self) -> GarbageCollection:
        garbage = GarbageCollection(lambda: self.now, lambda: self.growth)
        garbage.start()
        garbage.stop()
        return garbage


@pytest.mark.slow
def test_an_idle_server_collects_every_minute_and_a_busy_one_when_memory_has_grown() -> None:
    measured = Measured()
    garbage = measured.collection()
    measured.now = IDLE_S
    assert garbage.consider(busy=False)
    measured.now += BUSY_S - 1
    measured.growth = GROWTH_OBJECTS
    assert not garbage.consider(busy=True), "too soon"
    measured.now += 1
    assert garbage.consider(busy=True)
    measured.now += 10 * BUSY_S
    measured.growth = GROWTH_OBJECTS - 1
    assert not garbage.consider(busy=True), "nothing has grown"
    assert garbage.consider(busy=False)


def test_cycles_of_a_round_are_freed_while_others_play() -> None:
    class Node:
        """Something in a cycle."""

        alive = 0

        def __init__(self) -> None:
            Node.alive += 1
            self.me = self

        def __del__(self) -> None:
            Node.alive -= 1

    measured = Measured()
    garbage = measured.collection()
    before = gc.get_threshold()
    garbage.start()
    try:
        for _ in range(100):
            Node()
        measured.now, measured.growth = BUSY_S, GROWTH_OBJECTS
        assert garbage.consider(busy=True)
        assert Node.alive == 0
    finally:
        garbage.stop()
    assert gc.get_threshold() == before


def test_growth_is_that_since_the_last_collection() -> None:
    """Memory that has been free since an earlier collection hides nothing: the growth is counted in objects."""
    garbage = GarbageCollection()
    garbage.start()
    try:
        for _ in range(2):
            gc.collect()
            assert objects_since_collection() == 0
            kept = [[number] for number in range(60_000)]
            assert 0.8 * len(kept) < objects_since_collection() < 1.2 * len(kept)
            del kept
    finally:
        garbage.stop()


def test_the_limit_of_open_files_is_raised_or_named(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(resource, "setrlimit", lambda _, limit: told.append(limit))
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1024, 4096))
    assert raise_open_files(Limits(sockets=2000, rooms=250)) == ""
    assert told == [(4096, 4096)]
    assert "ulimit -n 9850" in raise_open_files(Limits(sockets=9000, rooms=250))
