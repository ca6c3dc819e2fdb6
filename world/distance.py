"""Distances around the walls: from a point to the nearest goal, or between two points.

The arena is cut into cells of 0.05; a breadth-first flood gives each cell its number of moves, and a move in any of
the 8 directions costs 0.05. A map's flood is made once and then looked up. Two grids over the same cells:

| grid | cells | a point belongs to | used by |
|---|---|---|---|
| `paper_distances` | 48 x 48 | the cell that contains it | NFD, the paper's reward, BASS |
| `official_distances` | 49 x 49 | the cell whose lower corner is nearest | the official dense reward, official NFD |

Source: the paper's "Normalized Final Distance Calculation"; what it leaves open (the directions, what a move costs,
when a cell is blocked) is as in the official code.

A cell is blocked when a wall overlaps it by more than 0.01 in both axes, and a goal cell when a drawn goal
does. A flood enters blocked cells but does not go on from them, so that a point in one still has a distance.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import cast

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec, Rect
from movingout.maps.flood_fill import CELL, PAPER_CELLS, UNREACHED, BitGrid, Mask, overlapped
from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats

OFFICIAL_CELLS = 49  # the last row and column stick out of the arena and are blocked
OFFICIAL_NO_WAY = 1.44  # the official code's distance of an item that cannot reach a goal

Cell = tuple[int, int]
Place = Cell | tuple[float, float]


class Distances:
    """Lookups on one grid of one map. Distances are in arena units, `math.inf` where there is no way."""

    def __init__(
        self,
        map_spec: MapSpec,
        cells: int,
        rounding: Callable[[Floats], Floats],
        scalar_rounding: Callable[[float], int],
    ) -> None:
        self.cells = cells
        self._rounding = rounding
        self._scalar_rounding = scalar_rounding  # the same for one number, without numpy's overhead
        self._blocked = overlapped(map_spec.walls, cells)
        self._blocked[PAPER_CELLS:, :] = self._blocked[:, PAPER_CELLS:] = True
        goal = overlapped(map_spec.goals, cells) & ~self._blocked
        self._to_goal = moves_to(goal, self._blocked) * CELL
        self._to_goal.setflags(write=False)
        self._to_cell: dict[Cell, Floats] = {}

    @property
    def farthest(self) -> float:
        """The largest finite distance to a goal on this map: what an item without a way counts as."""
        finite = self._to_goal[np.isfinite(self._to_goal)]
        return float(finite.max()) if finite.size else ARENA_HALF

    def to_goal(self, points: Floats) -> Floats:
        """Distances (...) of points (..., 2) to the nearest goal cell; 0 inside one."""
        indices = self._indices(points)
        found: Floats = self._to_goal[indices[..., 0], indices[..., 1]]
        return found

    def one_to_goal(self, point: Floats) -> float:
        """`to_goal` of one point (2,), faster."""
        return float(self._to_goal[self._cell(point)])

    def between(self, start: Floats, target: Floats) -> float:
        """Distance from one point (2,) to another; the flood of each target cell is kept.

        A target in a blocked cell is reached only from that same cell.
        """
        return self.between_cells(self._cell(start), self._cell(target))

    def between_cells(self, start: Cell, target: Cell) -> float:
        """`between` of two cells, for those who look up the same points often."""
        return self.to_cell(target).item(start)

    def to_cell(self, target: Cell) -> Floats:
        """The distances (cells, cells) of all cells to one; not to be changed."""
        found = self._to_cell.get(target)
        if found is None:
            found = self._to_cell[target] = self._flooded_from(target)
        return found

    def cell(self, x: float, y: float) -> Cell:
        """The cell that a point belongs to."""
        last, rounding = self.cells - 1, self._scalar_rounding
        column, row = rounding((x + ARENA_HALF) / CELL), rounding((y + ARENA_HALF) / CELL)
        if 0 <= column <= last and 0 <= row <= last:
            return column, row
        return min(max(column, 0), last), min(max(row, 0), last)

    def cell_to_goal(self, cell: Cell) -> float:
        """`to_goal` of a cell."""
        return self._to_goal.item(cell)

    def _flooded_from(self, cell: Cell) -> Floats:
        """Distances (cells, cells) to one cell; to a blocked one only from itself."""
        alone = np.zeros_like(self._blocked)
        alone[cell] = True
        if self._blocked[cell]:
            return np.where(alone, 0.0, math.inf)
        distances: Floats = moves_to(alone, self._blocked) * CELL
        return distances

    def _cell(self, point: Floats) -> Cell:
        x, y = point.tolist()
        return self.cell(x, y)

    def _indices(self, points: Floats) -> npt.NDArray[np.intp]:
        """Cells (..., 2) of points (..., 2); points beyond the arena belong to the outermost cells."""
        columns = self._rounding((points + ARENA_HALF) / CELL)
        return np.clip(columns, 0, self.cells - 1).astype(np.intp)


@lru_cache(maxsize=256)
def paper_distances(map_spec: MapSpec) -> Distances:
    """The paper's grid of a map, made once."""
    return Distances(map_spec, PAPER_CELLS, np.floor, math.floor)


class OfficialDistances:
    """The distances of the official code: straight lines on maps without walls, else moves on the 49 x 49 grid."""

    def __init__(self, map_spec: MapSpec) -> None:
        self._goals = map_spec.goals
        self._grid = Distances(map_spec, OFFICIAL_CELLS, np.rint, round) if map_spec.walls else None

    def to_goal(self, point: Floats) -> float:
        """From a point (2,) to the nearest drawn goal; 1.44 where there is no way."""
        if self._grid is None:
            return min(_to_rect(float(point[0]), float(point[1]), goal) for goal in self._goals)
        distance = self._grid.one_to_goal(point)
        return distance if math.isfinite(distance) else OFFICIAL_NO_WAY

    def place(self, x: float, y: float) -> Place:
        """A point for `between`: its cell, or on maps without walls the point itself."""
        return (x, y) if self._grid is None else self._grid.cell(x, y)

    def between(self, start: Place, target: Place) -> float:
        """From one place to another; `math.inf` where there is no way."""
        if self._grid is None:
            return math.hypot(target[0] - start[0], target[1] - start[1])
        return self._grid.between_cells(cast(Cell, start), cast(Cell, target))


@lru_cache(maxsize=64)
def official_distances(map_spec: MapSpec) -> OfficialDistances:
    """The official code's distances on a map, made once."""
    return OfficialDistances(map_spec)


def moves_to(sources: Mask, blocked: Mask) -> Floats:
    """Moves (n, n) from each cell to the nearest source, `inf` where there is no way; 8 directions, 1 move each."""
    grid = BitGrid(*blocked.shape)
    starts = grid.to_bits(sources)
    moves = grid.path_lengths(starts, grid.every_point, dead_ends=grid.to_bits(blocked) & ~starts)
    return np.where(moves == UNREACHED, np.inf, moves)


def _to_rect(x: float, y: float, rect: Rect) -> float:
    """Straight-line distance from a point to a rectangle, 0 inside it."""
    return math.hypot(max(rect.left - x, 0.0, x - rect.right), max(rect.bottom - y, 0.0, y - rect.top))


def gained(then: float, now: float) -> float:
    """The distance gained; 0 where there is no way in either state."""
    return then - now if math.isfinite(then) and math.isfinite(now) else 0.0
