import numpy as np

from agents.scripted.lattice import SLIDER, UNREACHED
from agents.scripted.searching import Field, Search
from agents.scripted.terrain import CELLS, terrain
from maps import load_map

GROUND = terrain(load_map("HandOff"), ())
ROW, COLUMN = (int(index) for index in np.unravel_index(int(np.argmax(GROUND.clearance)), (CELLS, CELLS)))


def _search() -> Search:
    starts = np.full((1, CELLS, CELLS), UNREACHED, dtype=np.int16)
    starts[0, ROW, COLUMN] = 5
    return Search(GROUND, ((0.0, 0.0, 0.05),), SLIDER, 0.004, starts)


def test_whoever_comes_second_to_a_search_sees_it_slice_by_slice_as_if_alone() -> None:
    shared = _search()
    ahead, behind, alone = Field(shared), Field(shared), Field(_search())
    while not ahead.done:
        ahead.search()
    while not alone.done:
        alone.search()
        behind.search()
        assert (behind.level, behind.done) == (alone.level, alone.done)
        assert np.array_equal(behind.cost, alone.cost)
    assert np.array_equal(behind.cost, ahead.cost)


def test_costs_grow_by_a_step_from_cell_to_cell() -> None:
    field = Field(_search())
    field.search()
    grid = field.cost.reshape(CELLS, CELLS)
    assert [int(grid[ROW, COLUMN + cells]) for cells in range(3)] == [5, 7, 9]
    assert int(grid[ROW + 1, COLUMN + 1]) == 8
