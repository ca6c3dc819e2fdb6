"""Free space: a grid of clearances, that is, distances to the nearest wall or resting item."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from weakref import WeakValueDictionary

import numpy as np

from movingout.agents.scripted.navigation.geometry import Disc, signed_distance
from movingout.maps import ItemSpec, MapSpec
from movingout.maps.flood_fill import BitGrid
from movingout.maps.spec import ARENA_HALF, ROBOT_RADIUS, WALL_MARGIN
from movingout.world.state import Floats

CELL = 0.03
CELLS = 81  # grid points per side, from -1.2 to 1.2
FLOOR = BitGrid(CELLS, CELLS)
AXIS: Floats = np.round(np.arange(CELLS) * CELL - ARENA_HALF, 9)
_FAR = 0.6  # clearances beyond this make no difference to a planner
_TOUCH = 0.003  # units: nearer than this counts as contact
_PRESSED, _PRESSED_PER_UNIT = 8.0, 1500.0  # quarter ticks: the cost of contact, and of each unit of overlap

Placed = tuple[ItemSpec, float, float, float]  # an item at x, y, angle


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class FreeSpace:
    """The arena with its obstacles. `clearance[row, column]` is at x = AXIS[column], y = AXIS[row]."""

    map: MapSpec
    items: tuple[Placed, ...]
    clearance: Floats  # (CELLS, CELLS), negative inside walls and items


# Users compare free spaces by identity, so an object that is still in use is returned again, even when the caches
# below have dropped it.
_alive: WeakValueDictionary[tuple[MapSpec, tuple[Placed, ...]], FreeSpace] = WeakValueDictionary()
_alive_with_robot: WeakValueDictionary[tuple[FreeSpace, float, float], FreeSpace] = WeakValueDictionary()


def free_space(map_spec: MapSpec, items: tuple[Placed, ...]) -> FreeSpace:
    """The free space of a map with these items as obstacles. Equal arguments give the same object."""
    return _free_space(
        map_spec, tuple(sorted(((i, round(x, 3), round(y, 3), round(a, 2)) for i, x, y, a in items), key=repr))
    )


@lru_cache(maxsize=64)
def _free_space(map_spec: MapSpec, items: tuple[Placed, ...]) -> FreeSpace:
    known = _alive.get((map_spec, items))
    if known is not None:
        return known
    clearance = _walls(map_spec).copy()
    for placed in items:
        rows, columns, distance = _around(placed)
        window = clearance[rows, columns]
        np.minimum(window, distance, out=window)
    space = _alive[map_spec, items] = FreeSpace(map_spec, items, clearance)
    return space


def standing_room(space: FreeSpace, radius: float) -> int:
    """The points, as bits of `FLOOR`, at which a disc of this radius fits."""
    return FLOOR.to_bits(space.clearance >= radius)


def with_robot(space: FreeSpace, position: Floats) -> FreeSpace:
    """Free space with a robot as an additional obstacle. Equal positions give the same object."""
    return _with_robot(space, round(float(position[0]), 2), round(float(position[1]), 2))


@lru_cache(maxsize=64)
def _with_robot(space: FreeSpace, x: float, y: float) -> FreeSpace:
    known = _alive_with_robot.get((space, x, y))
    if known is not None:
        return known
    grid_x, grid_y = np.meshgrid(AXIS, AXIS)
    gap = np.hypot(grid_x - x, grid_y - y) - ROBOT_RADIUS
    with_robot_on_it = FreeSpace(space.map, space.items, np.minimum(space.clearance, gap))
    _alive_with_robot[space, x, y] = with_robot_on_it
    return with_robot_on_it


@lru_cache(maxsize=64)
def _walls(map_spec: MapSpec) -> Floats:
    x, y = np.meshgrid(AXIS, AXIS)
    clearance = np.minimum(ARENA_HALF - np.abs(x), ARENA_HALF - np.abs(y))
    for wall in map_spec.walls:
        dx = np.maximum(wall.left - WALL_MARGIN - x, x - wall.right - WALL_MARGIN)
        dy = np.maximum(wall.bottom - WALL_MARGIN - y, y - wall.top - WALL_MARGIN)
        outside = np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0))
        clearance = np.minimum(clearance, outside + np.minimum(np.maximum(dx, dy), 0.0))
    return np.asarray(clearance)


@lru_cache(maxsize=512)
def _around(placed: Placed) -> tuple[slice, slice, Floats]:
    """(rows, columns, distances to the item's surface) of the window of the grid around an item."""
    item, x, y, angle = placed
    column, row = round((x + ARENA_HALF) / CELL), round((y + ARENA_HALF) / CELL)
    width = int(_FAR / CELL)
    columns = slice(max(column - width, 0), max(min(column + width + 1, CELLS), 0))
    rows = slice(max(row - width, 0), max(min(row + width + 1, CELLS), 0))
    grid_x, grid_y = np.meshgrid(AXIS[columns], AXIS[rows])
    points = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)
    distance = signed_distance(item, np.array([x, y, angle]), points)
    return rows, columns, distance.reshape(grid_x.shape)


def sample(grid: Floats, x: Floats, y: Floats) -> Floats:
    """Bilinear interpolation of a (CELLS, CELLS) grid at any points, clamped at the edge of the arena."""
    u = np.minimum(np.maximum((x + ARENA_HALF) / CELL, 0.0), CELLS - 1.001)
    v = np.minimum(np.maximum((y + ARENA_HALF) / CELL, 0.0), CELLS - 1.001)
    i, j = u.astype(np.intp), v.astype(np.intp)
    a, b = u - i, v - j
    at, left, below, costs_at_poses = j * CELLS + i, 1 - a, 1 - b, grid.ravel()
    return np.asarray(
        costs_at_poses.take(at) * left * below
        + costs_at_poses.take(at + 1) * a * below
        + costs_at_poses.take(at + CELLS) * left * b
        + costs_at_poses.take(at + CELLS + 1) * a * b
    )


def overlap_cost(space: FreeSpace, discs: Sequence[Disc], poses: Floats) -> Floats:
    """(...,) the cost of overlap with obstacles, for poses (..., 3) of a body made of discs."""
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y, radius = np.array(discs).T.reshape(3, -1, *(1 for _ in cos.shape))  # each (discs, 1, ...)
    clearance = sample(space.clearance, poses[..., 0] + cos * x - sin * y, poses[..., 1] + sin * x + cos * y)
    overlap = radius + _TOUCH - clearance
    return np.asarray(np.where(overlap > 0, _PRESSED + overlap * _PRESSED_PER_UNIT, 0.0).max(axis=0))


def cell_of(x: float, y: float) -> tuple[int, int]:
    """Row and column of the grid point nearest to (x, y)."""
    last = CELLS - 1
    return (
        min(max(round((y + ARENA_HALF) / CELL), 0), last),
        min(max(round((x + ARENA_HALF) / CELL), 0), last),
    )
