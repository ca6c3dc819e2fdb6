"""Routes of a robot without an item: walking costs, and the heading to take at each cell."""

import math
from collections.abc import Iterable, Sequence
from functools import cached_property, lru_cache

import numpy as np

from movingout.agents.scripted.navigation.free_space import AXIS, CELL, CELLS, FLOOR, FreeSpace, cell_of, standing_room
from movingout.agents.scripted.navigation.pose_grid import Cost
from movingout.maps.flood_fill import UNREACHED, Mask, StepCosts
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

WALKING = StepCosts(straight=2, diagonal=3, surcharge=3)  # quarter ticks
_MARGIN = 0.004  # units of clearance
_LOOK_AHEAD = 3  # doublings: the heading at a cell points 2**3 cells along the route
_TURN_COST = 9.0  # quarter ticks per radian off the route
_WITHIN_REACH = 10  # cells
_NEIGHBOURS = np.arange(-1, 3)[:, None]  # of a point, per axis
_HALF = 0.49  # of a cell: within this, a grid point is certainly the nearest
_SHIFTS = tuple((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1))
_FARTHEST = 2**_LOOK_AHEAD  # cells per axis
_STEPS = np.arange(-_FARTHEST, _FARTHEST + 1.0)
# Headings, by steps in y and in x. Not by NumPy's arctan2, which has other last bits where there is AVX-512.
_DIRECTIONS: Floats = np.array([[math.atan2(-dx, dy) for dx in _STEPS] for dy in _STEPS])
_HERE = np.arange(CELLS * CELLS)
_ROWS, _COLUMNS = np.divmod(_HERE, CELLS)

Point = tuple[float, float]
Cell = tuple[int, int]


def walking_costs(space: FreeSpace, targets: Sequence[Point], avoided: Mask | None = None) -> Cost:
    """(CELLS, CELLS) walking cost [quarter ticks] to the nearest of `targets`; UNREACHED where there is no route.

    Targets inside obstacles are moved to the nearest free cell. Steps from `avoided` cells (CELLS, CELLS) cost more
    than double.
    """
    cells = _standing_cells(space, tuple(targets))
    if avoided is None:
        return _lengths(space, cells)
    room = standing_room(space, ROBOT_RADIUS + _MARGIN)
    return FLOOR.path_lengths(_bits_of(cells), room, WALKING, avoided=FLOOR.to_bits(avoided))


@lru_cache(maxsize=64)
def _standing_cells(space: FreeSpace, targets: tuple[Point, ...]) -> frozenset[Cell]:
    free = space.clearance >= ROBOT_RADIUS + _MARGIN
    return frozenset(nearest_free(free, x, y, within=9) for x, y in targets)


def _bits_of(cells: Iterable[Cell]) -> int:
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    for cell in cells:
        mask[cell] = True
    return FLOOR.to_bits(mask)


@lru_cache(maxsize=64)
def _lengths(space: FreeSpace, cells: frozenset[Cell]) -> Cost:
    return FLOOR.path_lengths(_bits_of(cells), standing_room(space, ROBOT_RADIUS + _MARGIN), WALKING)


def nearest_free(free: Mask, x: float, y: float, within: int = 5) -> Cell:
    """Row and column of the free cell nearest to (x, y), or of the cell of (x, y) when none is near."""
    row, column = cell_of(x, y)
    if free[row, column] and abs(AXIS[row] - y) < _HALF * CELL and abs(AXIS[column] - x) < _HALF * CELL:
        return row, column
    rows, columns = slice(max(row - within, 0), row + within + 1), slice(max(column - within, 0), column + within + 1)
    found = np.argwhere(free[rows, columns])
    if not len(found):
        return row, column
    found += np.array([rows.start, columns.start])
    gaps = np.hypot(AXIS[found[:, 0]] - y, AXIS[found[:, 1]] - x)
    best = found[int(np.argmin(gaps))]
    return int(best[0]), int(best[1])


def cost_at(lengths_there: Cost, x: float, y: float) -> float:
    """Quarter ticks from (x, y); UNREACHED when there is no route."""
    return float(lengths_there[nearest_free(lengths_there < UNREACHED, x, y, within=4)])


def costs_beside(space: FreeSpace, position: Floats, poses: list[Floats]) -> list[float]:
    """Walking cost [quarter ticks] to within reach of each pose."""
    grid = walking_costs(space, [(float(position[0]), float(position[1]))])
    costs = []
    for pose in poses:
        row, column = cell_of(float(pose[0]), float(pose[1]))
        rows = slice(max(row - _WITHIN_REACH, 0), row + _WITHIN_REACH + 1)
        columns = slice(max(column - _WITHIN_REACH, 0), column + _WITHIN_REACH + 1)
        costs.append(float(grid[rows, columns].min()))
    return costs


class WalkingRoute:
    """The route to a place from anywhere, with the heading to take at each cell."""

    def __init__(self, there: Cost) -> None:
        """`there` (CELLS, CELLS): walking costs to the place."""
        self.lengths = there
        self._smooth = np.minimum(there.astype(np.float64), 2000.0)

    @cached_property
    def _ahead(self) -> tuple[Floats, Mask]:
        """(CELLS, CELLS) headings, and where the heading does not matter."""
        return _headings(_filled(self._smooth))

    def cost(self, x: float, y: float) -> float:
        """Quarter ticks from (x, y) to the target; UNREACHED when there is no route."""
        return cost_at(self.lengths, x, y)

    def costs(self, moves: Floats) -> Floats:
        """(K,) remaining cost at the end of short moves (K, HORIZON, 3), including turns."""
        ends = moves[:, -1]
        left = _values(self._smooth, ends)
        nearest = np.rint((ends[:, :2] - AXIS[0]) / CELL).astype(np.int64)
        columns, rows = np.minimum(np.maximum(nearest, 0), CELLS - 1).T
        cells = rows * CELLS + columns
        heading, near = self._ahead
        off = np.abs((ends[:, 2] - heading.take(cells) + math.pi) % (2 * math.pi) - math.pi)
        return left + np.where(near.take(cells), 0.0, off * _TURN_COST)

    def path(self, x: float, y: float, length: int) -> Floats:
        """(n <= length, 2) the cells of the route from (x, y)."""
        grid = self._smooth
        row, column = nearest_free(grid < 2000.0, x, y)
        cells = [(row, column)]
        while len(cells) < length and grid[row, column] > 0:
            rows, columns = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
            window = grid[rows, columns]
            step = np.unravel_index(int(np.argmin(window)), window.shape)
            following = (rows.start + int(step[0]), columns.start + int(step[1]))
            if grid[following] >= grid[row, column]:
                break
            row, column = following
            cells.append(following)
        indices = np.array(cells)
        return np.stack([AXIS[indices[:, 1]], AXIS[indices[:, 0]]], axis=1)


def route_to(space: FreeSpace, targets: Sequence[Point], avoided: Mask | None = None) -> WalkingRoute:
    """The route to the nearest of `targets`; see `walking_costs`."""
    if avoided is None:
        return _route(space, _standing_cells(space, tuple(targets)))
    return WalkingRoute(walking_costs(space, targets, avoided))


@lru_cache(maxsize=64)
def _route(space: FreeSpace, cells: frozenset[Cell]) -> WalkingRoute:
    return WalkingRoute(_lengths(space, cells))


def _filled(cost: Floats) -> Floats:
    """Costs extended a little into obstacles, where contact may push a robot: first out of the obstacle."""
    padded = np.full((CELLS + 2, CELLS + 2), 2000.0)
    filled = padded[1:-1, 1:-1]
    filled[:] = cost
    for _ in range(3):
        lowest = np.minimum(padded[:-2], padded[2:])
        np.minimum(lowest, padded[1:-1], out=lowest)
        lowest = np.minimum(np.minimum(lowest[:, :-2], lowest[:, 2:]), lowest[:, 1:-1])
        np.copyto(filled, np.minimum(lowest + 5.0, 2000.0), where=filled >= 2000.0)
    return filled


def _values(grid: Floats, poses: Floats) -> Floats:
    u, v = (poses[:, 0] - AXIS[0]) / CELL, (poses[:, 1] - AXIS[0]) / CELL
    i = np.minimum(np.maximum(np.floor(u).astype(np.int64) + _NEIGHBOURS, 0), CELLS - 1)  # (4, M)
    j = np.minimum(np.maximum(np.floor(v).astype(np.int64) + _NEIGHBOURS, 0), CELLS - 1)
    gap = np.hypot((v - j)[:, None], u - i) * 2.0  # (4, 4, M)
    total = grid.take((j * CELLS)[:, None] + i) + gap
    return np.asarray(total.reshape(-1, len(poses)).min(axis=0))


def _headings(cost: Floats) -> tuple[Floats, Mask]:
    """For each cell the heading of the route, and whether the target is so near that the heading does not matter."""
    padded = np.full((CELLS + 2, CELLS + 2), 1e9)
    padded[1:-1, 1:-1] = cost
    lowest = padded[:-2, :-2].copy()
    offset = np.full((CELLS, CELLS), -CELLS - 1)
    for dy, dx in _SHIFTS[1:]:  # the first of equal ones is kept
        there = padded[1 + dy : 1 + dy + CELLS, 1 + dx : 1 + dx + CELLS]
        np.copyto(offset, dy * CELLS + dx, where=there < lowest)
        np.minimum(lowest, there, out=lowest)
    following = _HERE + offset.ravel()
    for _ in range(_LOOK_AHEAD):
        following = following.take(following)
    dx, dy = _COLUMNS.take(following) - _COLUMNS, _ROWS.take(following) - _ROWS
    near = (np.maximum(np.abs(dx), np.abs(dy)) <= 1).reshape(CELLS, CELLS)
    step = (dy + _FARTHEST) * len(_STEPS) + dx + _FARTHEST
    return _DIRECTIONS.take(step).reshape(CELLS, CELLS), near
