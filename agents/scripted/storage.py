"""Where in the goal regions an item is best put down, so that every other item still finds its place."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from agents.scripted.lattice import UNREACHED, Cost, Field, Motion
from agents.scripted.terrain import AXIS, CELL, CELLS, Terrain, terrain
from agents.scripted.walking import WALKER, grid_of
from maps import ItemSpec, MapSpec
from maps.shapes import circumradius
from world.scoring import goal_boxes
from world.state import Floats

_INSET = 0.012  # an item is put down this far inside the region that counts
_TRAPPED = 120.0  # quarter ticks: a robot deeper in the region than its item might not get out again
_ROOMY = 0.16  # share of the goal regions that the items cover, below which any place will do
_COMPACT = 60.0  # quarter ticks per unit of free space around a place


@dataclass(frozen=True, slots=True, eq=False)
class Storage:
    """The goal regions of a map. `depth` (CELLS, CELLS) is the way out of the region, in quarter ticks."""

    map: MapSpec
    depth: Floats
    crowded: bool


@lru_cache(maxsize=64)
def storage(map_spec: MapSpec) -> Storage:
    """The storage of a map."""
    outside = np.ones((CELLS, CELLS), dtype=np.bool_)
    x, y = np.meshgrid(AXIS, AXIS)
    for goal in map_spec.goals:
        outside &= ~((x > goal.left) & (x < goal.right) & (y > goal.bottom) & (y < goal.top))
    field = Field(terrain(map_spec, ()), ((0.0, 0.0, 0.02),), WALKER, margin=0.0)
    field.seed(np.where(outside, 0, UNREACHED).astype(np.int16)[None])
    field.search(4000)
    depth = np.where(grid_of(field) < UNREACHED, grid_of(field), 0).astype(np.float64)
    area = sum((goal.right - goal.left) * (goal.top - goal.bottom) for goal in map_spec.goals)
    covered = sum((2 * circumradius(item.shape, item.scale)) ** 2 for item in map_spec.items)
    return Storage(map_spec, depth, covered / area > _ROOMY)


def place_costs(
    store: Storage,
    ground: Terrain,
    motion: Motion,
    offset: tuple[float, float],
    extents: Floats,
) -> Cost:
    """Start costs (headings, CELLS, CELLS) of putting an item down, for `Field.seed`.

    `offset` is the item's centre in the frame of the body's reference point; `extents` (headings, 2) are half the
    width and height of its bounding box. Poses that do not deliver it are UNREACHED.
    """
    angles = np.arange(motion.headings) * 2 * np.pi / motion.headings
    dx = offset[0] * np.cos(angles) - offset[1] * np.sin(angles)
    dy = offset[0] * np.sin(angles) + offset[1] * np.cos(angles)
    x = AXIS[None, None, :] + dx[:, None, None]
    y = AXIS[None, :, None] + dy[:, None, None]
    inside = np.zeros((motion.headings, CELLS, CELLS), dtype=np.bool_)
    for left, bottom, right, top in goal_boxes(store.map):
        wide, high = extents[:, 0, None, None] + _INSET, extents[:, 1, None, None] + _INSET
        inside |= (x > left + wide) & (x < right - wide) & (y > bottom + high) & (y < top - high)
    costs = np.full(inside.shape, UNREACHED, dtype=np.int16)
    heading, row, column = np.nonzero(inside)
    item_row = np.clip(np.rint((y[heading, row, 0] - AXIS[0]) / CELL).astype(np.int64), 0, CELLS - 1)
    item_column = np.clip(np.rint((x[heading, 0, column] - AXIS[0]) / CELL).astype(np.int64), 0, CELLS - 1)
    costs[inside] = _preference(store, ground, (item_row, item_column), (row, column)).astype(np.int16)
    return costs


def _preference(
    store: Storage,
    ground: Terrain,
    item: tuple[np.ndarray, np.ndarray],
    robot: tuple[np.ndarray, np.ndarray],
) -> Floats:
    depth = store.depth[item]
    eager = 2.0 if store.crowded else 0.25
    shallow = eager * (store.depth.max() - depth)
    loose = (_COMPACT if store.crowded else 0.0) * np.clip(ground.clearance[item], 0.0, 0.3)
    trapped = np.where(store.depth[robot] > depth + 3.0, _TRAPPED, 0.0)
    return np.asarray(shallow + loose + trapped)


def is_crowded(items: tuple[ItemSpec, ...], map_spec: MapSpec) -> bool:
    """Whether these items fill the goal regions so far that places matter."""
    area = sum((goal.right - goal.left) * (goal.top - goal.bottom) for goal in map_spec.goals)
    return sum((2 * circumradius(item.shape, item.scale)) ** 2 for item in items) / area > _ROOMY
