"""Randomised maps that were made ahead are found again; the oldest give way to new ones."""

import pytest

from movingout.maps import load_map
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
