import numpy as np
import numpy.typing as npt
import pytest

from movingout.maps.flood_fill import UNREACHED, BitGrid, Mask, StepCosts

SIDE = 81
GRID = BitGrid(SIDE, SIDE)
START = (40, 10)


def _floor() -> Mask:
    """A floor with a wall that leaves a gap at the top, and a room without a door."""
    floor = np.zeros((SIDE, SIDE), dtype=np.bool_)
    floor[1:-1, 1:-1] = True
    floor[:70, 40] = False
    floor[5:15, 60] = floor[5:15, 70] = floor[5, 60:71] = floor[14, 60:71] = False
    return floor


def _one(cell: tuple[int, int]) -> int:
    mask = np.zeros((SIDE, SIDE), dtype=np.bool_)
    mask[cell] = True
    return GRID.to_bits(mask)


def _dijkstra(floor: Mask, costs: StepCosts, avoided_columns: int) -> npt.NDArray[np.int64]:
    """What a plain search finds; steps from columns below `avoided_columns` cost the surcharge."""
    found = np.full(floor.shape, UNREACHED)
    found[START] = 0
    front = [(0, START)]
    while front:
        front.sort(reverse=True)
        length, (row, column) = front.pop()
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                there = row + down, column + right
                if (down or right) and floor[there]:
                    cost = length + (costs.diagonal if down and right else costs.straight)
                    cost += costs.surcharge if there[1] < avoided_columns else 0
                    if cost < found[there]:
                        found[there] = cost
                        front.append((cost, there))
    return found


@pytest.mark.parametrize("costs", [StepCosts(), StepCosts(2, 3, 3), StepCosts(1, 2, 5)])
@pytest.mark.parametrize("avoided_columns", [0, 20])
def test_paths_are_as_long_as_a_plain_search_finds_them(costs: StepCosts, avoided_columns: int) -> None:
    floor = _floor()
    avoided = np.zeros_like(floor)
    avoided[:, :avoided_columns] = True
    lengths = GRID.path_lengths(_one(START), GRID.to_bits(floor), costs, avoided=GRID.to_bits(avoided))
    assert np.array_equal(lengths, _dijkstra(floor, costs, avoided_columns))


def test_no_path_leads_on_from_a_dead_end() -> None:
    grid = BitGrid(3, 4)
    wall = np.zeros((3, 4), dtype=np.bool_)
    wall[:, 2] = True
    start = np.zeros_like(wall)
    start[0, 0] = True
    lengths = grid.path_lengths(grid.to_bits(start), grid.every_point, dead_ends=grid.to_bits(wall))
    assert lengths.tolist() == [[0, 1, 2, UNREACHED], [1, 1, 2, UNREACHED], [2, 2, 2, UNREACHED]]


def test_a_room_without_a_door_is_not_connected() -> None:
    floor = _floor()
    reached = GRID.to_mask(GRID.connected(_one(START), GRID.to_bits(floor)))
    assert reached[60, 70] and not reached[10, 65] and floor[10, 65]
    assert np.array_equal(reached, GRID.path_lengths(_one(START), GRID.to_bits(floor)) < UNREACHED)


def test_points_that_touch_at_a_corner_are_connected_only_along_diagonals() -> None:
    grid = BitGrid(2, 3)
    points = grid.to_bits(np.array([[True, False, False], [False, True, True]]))
    assert grid.components(points, points) == [points]
    apart = [grid.to_mask(part).tolist() for part in grid.components(points, points, diagonals=False)]
    assert apart == [[[True, False, False], [False, False, False]], [[False, False, False], [False, True, True]]]


def test_the_end_of_a_row_is_not_beside_the_start_of_the_next() -> None:
    grid = BitGrid(2, 3)
    end, following = np.array([[False, False, True], [False] * 3]), np.array([[False] * 3, [True, False, False]])
    both = grid.to_bits(end | following)
    assert len(grid.components(both, both)) == 2
    assert grid.to_mask(grid.dilated(grid.to_bits(end), 1)).tolist() == [[False, True, True]] * 2


def test_masks_survive_being_written_as_an_integer() -> None:
    assert np.array_equal(GRID.to_mask(GRID.to_bits(_floor())), _floor())


@pytest.mark.parametrize(("row", "column"), [(70, 40), (75, 40), (40, 38), (40, 20), (3, 65), (20, 62), (74, 44)])
@pytest.mark.parametrize("size", [1, 4, 8])
def test_around_a_hole_as_much_is_connected_as_a_plain_fill_finds(row: int, column: int, size: int) -> None:
    component = GRID.connected(_one(START), GRID.to_bits(_floor()))
    mask = np.zeros((SIDE, SIDE), dtype=np.bool_)
    mask[row - size : row + size, column - size : column + size] = True
    hole = GRID.to_bits(mask)
    for start in (_one(START), _one((60, 70)), _one((row, column)), _one(START) | _one((60, 70))):
        assert GRID.connected_around(hole, start, component) == GRID.connected(start & ~hole, component & ~hole)
