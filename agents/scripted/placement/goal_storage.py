"""The goals of a map as storage: their depth, how crowded they will be, and planned places."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import AXIS, CELL, CELLS, FLOOR, free_space, standing_room
from movingout.agents.scripted.navigation.walking_route import WALKING
from movingout.agents.scripted.placement.remaining_items import Point
from movingout.maps import MapSpec
from movingout.maps.flood_fill import UNREACHED, Mask
from movingout.maps.shapes import circumradius
from movingout.world.scoring import goal_boxes
from movingout.world.state import Floats

Cells = npt.NDArray[np.int64]

INSET = 0.012  # units that items are put down inside of the region that counts
_ROOMY = 0.16  # share of the goals covered by items, below which any place will do
EXACT_CROWDING = 2.0  # crowding from which items must be placed exactly
_DENSE = 0.25  # share from which the choice of places matters increasingly


@dataclass(frozen=True, slots=True, eq=False)
class GoalStorage:
    """The goals of a map. `depth` (CELLS, CELLS) is the path out of the region, in quarter ticks."""

    map: MapSpec
    depth: Floats
    inside: Mask
    slots: Floats  # (n, 2) planned places for maps with small items only and little room, else none
    crowding: float  # 0 with enough room, else at least 1


@lru_cache(maxsize=64)
def goal_storage(map_spec: MapSpec) -> GoalStorage:
    """The goal storage of a map."""
    inside = np.zeros((CELLS, CELLS), dtype=np.bool_)
    x, y = np.meshgrid(AXIS, AXIS)
    for goal in map_spec.goals:
        inside |= (x > goal.left) & (x < goal.right) & (y > goal.bottom) & (y < goal.top)
    exit_path = FLOOR.path_lengths(FLOOR.to_bits(~inside), standing_room(free_space(map_spec, ()), 0.02), WALKING)
    depth = np.where(exit_path < UNREACHED, exit_path, 0).astype(np.float64)
    area = sum((goal.right - goal.left) * (goal.top - goal.bottom) for goal in map_spec.goals)
    radii = [circumradius(item.shape, item.scale) for item in map_spec.items]
    share = sum((2 * radius) ** 2 for radius in radii) / area
    crowding = min(max(share / _DENSE, 1.0), 3.0) if share > _ROOMY else 0.0
    planned = crowding > 0.0 and all(item.size == "small" for item in map_spec.items)
    slots = _slots(map_spec, depth, sum(radii) / len(radii), len(radii)) if planned else np.empty((0, 2))
    return GoalStorage(map_spec, depth, inside, slots, crowding)


def _slots(map_spec: MapSpec, depth: Floats, radius: float, number: int) -> Floats:
    """(number, 2) places as far apart as possible, beginning at the deepest one."""
    x, y = np.meshgrid(AXIS, AXIS)
    room = free_space(map_spec, ()).clearance >= radius + 0.004
    rows, columns = np.nonzero(room & within_goals(map_spec, x, y, radius + INSET))
    if not len(rows):
        return np.empty((0, 2))
    points = np.stack([AXIS[columns], AXIS[rows]], axis=1)
    gaps = np.hypot(*(points[:, None, :] - points[None]).transpose(2, 0, 1))
    chosen = [int(np.argmax(depth[rows, columns]))]
    for _ in range(number - 1):
        chosen.append(int(np.argmax(gaps[chosen].min(axis=0))))
    for place in 2 * list(range(1, number)):  # each once more, now that the others are known
        others = [other for other in chosen if other != chosen[place]]
        chosen[place] = int(np.argmax(gaps[others].min(axis=0))) if others else chosen[place]
    return points[chosen]


def within_goals(map_spec: MapSpec, x: Floats, y: Floats, radius: float) -> npt.NDArray[np.bool_]:
    """Whether discs lie within a goal, ignoring their outermost tenth, which may be a corner."""
    inside = np.zeros(x.shape, dtype=np.bool_)
    size = 0.9 * radius
    for left, bottom, right, top in goal_boxes(map_spec):
        inside |= (x > left + size) & (x < right - size) & (y > bottom + size) & (y < top - size)
    return inside


def moved(offset: Point, angles: Floats) -> tuple[Floats, Floats]:
    """x (headings, 1, CELLS) and y (headings, CELLS, 1) of a point of the body, for every reference pose."""
    dx = offset[0] * np.cos(angles) - offset[1] * np.sin(angles)
    dy = offset[0] * np.sin(angles) + offset[1] * np.cos(angles)
    return AXIS[None, None, :] + dx[:, None, None], AXIS[None, :, None] + dy[:, None, None]


def cells(x: Floats, y: Floats) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    rows = np.rint((y - AXIS[0]) / CELL).astype(np.int64)
    columns = np.rint((x - AXIS[0]) / CELL).astype(np.int64)
    return np.minimum(np.maximum(rows, 0), CELLS - 1), np.minimum(np.maximum(columns, 0), CELLS - 1)
