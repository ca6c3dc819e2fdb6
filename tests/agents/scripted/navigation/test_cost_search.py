from collections import defaultdict

import numpy as np
import pytest

from movingout.agents.scripted.navigation.cost_search import LEVELS_PER_SLICE, CostToGo, Search
from movingout.agents.scripted.navigation.free_space import CELLS, free_space
from movingout.agents.scripted.navigation.pose_grid import DRAG_MOTION, SOLO_MOTION, Cost
from movingout.maps import load_map
from movingout.maps.flood_fill import UNREACHED

GROUND = free_space(load_map("HandOff"), ())
ROW, COLUMN = (int(index) for index in np.unravel_index(int(np.argmax(GROUND.clearance)), (CELLS, CELLS)))


def _search() -> Search:
    starts = np.full((1, CELLS, CELLS), UNREACHED, dtype=np.int16)
    starts[0, ROW, COLUMN] = 5
    return Search(GROUND, ((0.0, 0.0, 0.05),), DRAG_MOTION, 0.004, starts)


def test_a_second_user_of_a_search_sees_it_slice_by_slice_as_if_alone() -> None:
    shared = _search()
    ahead, behind, alone = CostToGo(shared), CostToGo(shared), CostToGo(_search())
    while not ahead.done:
        ahead.search()
    while not alone.done:
        alone.search()
        behind.search()
        assert (behind.level, behind.done) == (alone.level, alone.done)
        assert np.array_equal(behind.cost, alone.cost)
    assert np.array_equal(behind.cost, ahead.cost)


def test_costs_grow_by_a_step_from_cell_to_cell() -> None:
    field = CostToGo(_search())
    field.search()
    grid = field.cost.reshape(CELLS, CELLS)
    assert [int(grid[ROW, COLUMN + cells]) for cells in range(3)] == [5, 7, 9]
    assert int(grid[ROW + 1, COLUMN + 1]) == 8


def _level_by_level(free: list[bool], starts: Cost, slices: int) -> tuple[list[int], int, bool]:
    """What a plain search of a carrier knows after so many slices: costs, the next level, whether nothing waits."""
    costs, waiting = starts.tolist(), defaultdict(list)
    for pose in np.flatnonzero(starts < UNREACHED).tolist():
        waiting[costs[pose]].append(pose)
    first = level = min(waiting)
    while level < first + slices * LEVELS_PER_SLICE:
        if not waiting:
            return costs, level + 1, True
        now = {pose for pose in waiting.pop(level, []) if costs[pose] == level}
        offers: dict[int, int] = {}
        for pose in now:
            heading, cell = divmod(pose, CELLS * CELLS)
            for dx, dy, turn, price in SOLO_MOTION.moves[heading]:
                before = (heading - turn) % SOLO_MOTION.headings * CELLS * CELLS + cell - dy * CELLS - dx
                if free[before] and costs[before] > level + price:
                    waiting[level + price].append(before)
                    offers[before] = min(offers.get(before, UNREACHED), level + price)
        for pose, cost in offers.items():
            costs[pose] = cost
        level += 1
    return costs, level, False


@pytest.mark.parametrize("later", range(0, 128, 8))
def test_a_search_knows_after_each_slice_what_a_plain_one_knows(later: int) -> None:
    """Two levels are expanded at once, whatever the starts are and wherever the search ends."""
    free = np.tile((GROUND.clearance >= 0.1).ravel(), SOLO_MOTION.headings)
    near = np.flatnonzero(free)
    starts = np.full(free.size, UNREACHED, dtype=np.int16)
    starts[near[[0, 1, 5]]] = 7, 8, 7 + later  # the later one decides when it ends
    field = CostToGo(Search(GROUND, [(0.0, 0.0, 0.1)], SOLO_MOTION, 0.0, starts))
    slices = 0
    while not field.done:
        field.search()
        slices += 1
        costs, level, done = _level_by_level(free.tolist(), starts, slices)
        assert (field.level, field.done) == (level, done)
        assert field.cost.tolist() == costs
