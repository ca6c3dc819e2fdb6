"""Where something of a given width fits between the walls: to check that a map can be solved.

Everything is sampled on a grid of points 0.025 apart; what moves counts as a disc, which any turned shape is within.
Items are not obstacles here, since they can be carried away.
"""

import math
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.maps.flood_fill import BitGrid, Mask
from movingout.maps.spec import ARENA_HALF, ROBOT_RADIUS, WALL_MARGIN, Rect

SPACING = 0.025
_SIDE = round(2 * ARENA_HALF / SPACING) + 1
_AXIS = np.linspace(-ARENA_HALF, ARENA_HALF, _SIDE)
GRID = np.stack(np.meshgrid(_AXIS, _AXIS, indexing="ij"), axis=-1)  # (_SIDE, _SIDE, 2) x, y
_POINTS = BitGrid(_SIDE, _SIDE)
_AROUND = 0.05  # a place counts as good as the best sample this near to it

Grid = npt.NDArray[np.float64]


def distances_from(rect: Rect) -> Grid:
    """(97, 97) how far each point is from a rectangle; 0 inside."""
    x, y = GRID[..., 0], GRID[..., 1]
    across = np.maximum(np.maximum(rect.left - x, x - rect.right), 0.0)
    return np.asarray(np.hypot(across, np.maximum(np.maximum(rect.bottom - y, y - rect.top), 0.0)))


@lru_cache(maxsize=64)
def clearance(walls: tuple[Rect, ...]) -> Grid:
    """(97, 97) how large a disc fits at each point: its distance to the nearest wall or side of the arena."""
    x, y = GRID[..., 0], GRID[..., 1]
    room = ARENA_HALF - np.maximum(np.abs(x), np.abs(y))
    for wall in walls:
        room = np.minimum(room, distances_from(wall) - WALL_MARGIN)
    room.setflags(write=False)
    return room


@lru_cache(maxsize=64)
def way_to_goal(walls: tuple[Rect, ...], goals: tuple[Rect, ...]) -> Grid:
    """(97, 97) the largest disc radius that gets from each point into some drawn goal."""
    x, y = GRID[..., 0], GRID[..., 1]
    inside = np.zeros(x.shape, dtype=np.bool_)
    for goal in goals:
        inside |= (x >= goal.left) & (x <= goal.right) & (y >= goal.bottom) & (y <= goal.top)
    return widest(clearance(walls), inside)


@lru_cache(maxsize=64)
def robot_areas(walls: tuple[Rect, ...]) -> npt.NDArray[np.int64]:
    """(97, 97) the number, from 1, of the connected area in which a robot's centre can be at each point; 0 for none."""
    free = _POINTS.to_bits(clearance(walls) >= ROBOT_RADIUS)
    areas = np.zeros((_SIDE, _SIDE), dtype=np.int64)
    for number, area in enumerate(_POINTS.components(free, free, diagonals=False), start=1):
        areas[_POINTS.to_mask(area)] = number
    areas.setflags(write=False)
    return areas


def areas_near(walls: tuple[Rect, ...], x: float, y: float) -> set[int]:
    """The areas in which a robot at (x, y) is: normally one."""
    return set(_values_near(robot_areas(walls), x, y).tolist()) - {0}


def best_near(grid: Grid, x: float, y: float) -> float:
    """The largest value around a place."""
    return float(_values_near(grid, x, y).max())


def window(x: float, y: float, radius: float) -> tuple[slice, slice]:
    """The part of the grid within a square around a place."""
    reach = math.ceil(radius / SPACING)
    column, row = (round((min(max(value, -ARENA_HALF), ARENA_HALF) + ARENA_HALF) / SPACING) for value in (x, y))
    return slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1)


def _values_near(grid: npt.NDArray[Any], x: float, y: float) -> npt.NDArray[Any]:
    part = window(x, y, _AROUND)
    points = GRID[part]
    return np.asarray(grid[part][np.hypot(points[..., 0] - x, points[..., 1] - y) <= _AROUND])


def widest(room: Grid, sources: Mask) -> Grid:
    """For each point the widest path to a source, where a path is as wide as its narrowest point; -inf without one.

    Every point takes the widest of its 8 neighbours' paths, as far as it has room itself, until nothing changes.
    """
    best = np.full((room.shape[0] + 2, room.shape[1] + 2), -math.inf)
    inner = best[1:-1, 1:-1]
    inner[sources] = room[sources]
    while True:
        rows = np.maximum(np.maximum(best[:-2], best[1:-1]), best[2:])
        around = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
        wider = np.maximum(inner, np.minimum(room, around))
        if np.array_equal(wider, inner):
            return wider
        inner[:] = wider
