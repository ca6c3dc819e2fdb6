"""Randomised maps that were made ahead are found again, the oldest give way, and what is missing is made elsewhere."""

import asyncio

import pytest

from movingout.maps import MapError, MapSpec, load_map
from movingout.maps.randomize import randomize
from movingout.server.rooms import prepared_maps
from movingout.server.rooms.prepared_maps import PreparedMaps


def test_a_prepared_map_is_the_one_that_was_kept_and_another_is_made_now() -> None:
    designed, made = load_map("HandOff"), load_map("LeftRight")
    maps = PreparedMaps()
    maps.keep((designed, 7, "train"), made)
    assert maps.world_map(designed, None, "train") is designed
    assert maps.world_map(designed, 7, "train") is made
    assert maps.world_map(designed, 8, "train") == randomize(designed, 8, "train")


def test_the_oldest_give_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(prepared_maps, "KEPT", 2)
    designed = load_map("HandOff")
    maps = PreparedMaps()
    for seed in (5, 3, 4):
        maps.keep((designed, seed, "train"), designed)
    assert [seed for (_, seed, _), _ in maps] == [3, 4]
    assert (designed, 5, "train") not in maps and (designed, 3, "train") in maps
    for seed in (3, 6):
        maps.keep((designed, seed, "train"), designed)
    assert [seed for (_, seed, _), _ in maps] == [3, 6], "what is kept again is the newest"


def test_what_a_round_misses_is_made_once_and_what_cannot_be_made_is_said_at_once() -> None:
    designed, asked = load_map("HandOff"), list[int]()

    async def make(spec: MapSpec, seed: int, split: str) -> MapSpec:
        asked.append(seed)
        if seed == 8:
            raise MapError("no playable variant")
        return spec

    async def work() -> None:
        maps = PreparedMaps(make)
        assert maps.is_ready(designed, None, "train")
        assert not any(maps.is_ready(designed, seed, "train") for seed in (7, 8, 7, 8))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        assert maps.is_ready(designed, 7, "train") and maps.world_map(designed, 7, "train") is designed
        with pytest.raises(MapError, match="no playable variant"):
            maps.world_map(designed, 8, "train")
        await maps.prepare(designed, 9, "train")
        assert (designed, 9, "train") in maps
        with pytest.raises(MapError, match="no playable variant"):
            await maps.prepare(designed, 8, "train")

    asyncio.run(work())
    assert asked == [7, 8, 9]


def test_without_another_process_it_is_made_when_it_is_wanted() -> None:
    assert PreparedMaps().is_ready(load_map("HandOff"), 7, "train")


def test_what_could_be_made_later_is_there() -> None:
    designed = load_map("HandOff")

    async def make(spec: MapSpec, seed: int, split: str) -> MapSpec:
        raise MapError("the process died twice")

    async def work() -> MapSpec:
        maps = PreparedMaps(make)
        with pytest.raises(MapError):
            await maps.prepare(designed, 7, "train")
        maps.keep((designed, 7, "train"), designed)
        return maps.world_map(designed, 7, "train")

    assert asyncio.run(work()) is designed
