import numpy as np
import pytest

from movingout.agents.scripted.navigation.flood_fill import flood, flood_around, lengths, to_bits, to_mask
from movingout.agents.scripted.navigation.lattice import UNREACHED
from movingout.agents.scripted.navigation.terrain import CELLS

START = (40, 10)


def _floor() -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """A floor with a wall that leaves a gap at the top, and a room without a door."""
    floor = np.zeros((CELLS, CELLS), dtype=np.bool_)
    floor[1:-1, 1:-1] = True
    floor[:70, 40] = False
    floor[5:15, 60] = floor[5:15, 70] = floor[5, 60:71] = floor[14, 60:71] = False
    return floor


def _one(cell: tuple[int, int]) -> int:
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    mask[cell] = True
    return to_bits(mask)


def _settled(floor: np.ndarray[tuple[int, int], np.dtype[np.bool_]], dear: int) -> dict[tuple[int, int], int]:
    """What a plain search finds: steps of 2 and 3 quarter ticks, and 3 more from columns below `dear`."""
    found = {START: 0}
    front = [(0, START)]
    while front:
        front.sort(reverse=True)
        length, (row, column) = front.pop()
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                there = row + down, column + right
                if (down or right) and floor[there]:
                    cost = length + (3 if down and right else 2) + (3 if there[1] < dear else 0)
                    if cost < found.get(there, UNREACHED):
                        found[there] = cost
                        front.append((cost, there))
    return found


@pytest.mark.parametrize("dear", [0, 20])
def test_ways_are_as_long_as_a_plain_search_finds_them(dear: int) -> None:
    floor = _floor()
    shunned = np.zeros_like(floor)
    shunned[:, :dear] = True
    expected = np.full((CELLS, CELLS), UNREACHED)
    for cell, length in _settled(floor, dear).items():
        expected[cell] = length
    assert np.array_equal(lengths(_one(START), to_bits(floor), to_bits(shunned)), expected)


def test_a_room_without_a_door_is_not_reached() -> None:
    floor = _floor()
    reached = to_mask(flood(_one(START), to_bits(floor)))
    assert reached[60, 70] and not reached[10, 65] and floor[10, 65]
    assert np.array_equal(reached, lengths(_one(START), to_bits(floor)) < UNREACHED)


def test_masks_survive_being_written_as_an_integer() -> None:
    assert np.array_equal(to_mask(to_bits(_floor())), _floor())


@pytest.mark.parametrize(("row", "column"), [(70, 40), (75, 40), (40, 38), (40, 20), (3, 65), (20, 62), (74, 44)])
@pytest.mark.parametrize("size", [1, 4, 8])
def test_around_a_hole_as_much_hangs_together_as_a_plain_flood_finds(row: int, column: int, size: int) -> None:
    whole = flood(_one(START), to_bits(_floor()))
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    mask[row - size : row + size, column - size : column + size] = True
    hole = to_bits(mask)
    for start in (_one(START), _one((60, 70)), _one((row, column)), _one(START) | _one((60, 70))):
        assert flood_around(hole, start, whole) == flood(start & ~hole, whole & ~hole)
