"""Where in the goal regions an item is best put down, so that every other item still finds its place.

Three rules, as prices on places: far in before near the edge where room is scarce; never where it would cut the
floor in two or shut a robot in; close to walls and to what lies there already.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.scripted.flood import Mask, flood, grown, standing_room, to_bits, to_mask
from agents.scripted.lattice import UNREACHED, Cost, Field, Motion
from agents.scripted.terrain import AXIS, CELL, CELLS, Terrain, sample, terrain
from agents.scripted.walking import WALKER, grid_of
from maps import MapSpec
from maps.shapes import circumradius
from maps.spec import ROBOT_RADIUS
from world.scoring import goal_boxes
from world.state import Floats

Point = tuple[float, float]
Cells = npt.NDArray[np.int64]

_INSET = 0.012  # an item is put down this far inside the region that counts
_ROOMY = 0.16  # share of the goal regions that the items cover, below which any place will do
_EAGER = 2.5  # quarter ticks per quarter tick of depth, where room is scarce
_COMPACT = 60.0  # quarter ticks per unit of free space around a place
_SHUT_IN = 150.0  # quarter ticks: the robot could not get out again
_CUTS = 250.0  # quarter ticks: the item would part the floor
_ROOM = 90.0  # quarter ticks: taking all the room that the largest item to come would need


class Outlook(NamedTuple):
    """What is still to be delivered besides an item: where it waits, and the radius of the largest (0: nothing)."""

    points: tuple[Point, ...]
    largest: float


@dataclass(frozen=True, slots=True, eq=False)
class Storage:
    """The goal regions of a map. `depth` (CELLS, CELLS) is the way out of the region, in quarter ticks."""

    map: MapSpec
    depth: Floats
    inside: Mask
    crowded: bool


@lru_cache(maxsize=64)
def storage(map_spec: MapSpec) -> Storage:
    """The storage of a map."""
    inside = np.zeros((CELLS, CELLS), dtype=np.bool_)
    x, y = np.meshgrid(AXIS, AXIS)
    for goal in map_spec.goals:
        inside |= (x > goal.left) & (x < goal.right) & (y > goal.bottom) & (y < goal.top)
    field = Field(terrain(map_spec, ()), ((0.0, 0.0, 0.02),), WALKER, margin=0.0)
    field.seed(np.where(inside, UNREACHED, 0).astype(np.int16)[None])
    field.search(4000)
    depth = np.where(grid_of(field) < UNREACHED, grid_of(field), 0).astype(np.float64)
    area = sum((goal.right - goal.left) * (goal.top - goal.bottom) for goal in map_spec.goals)
    covered = sum((2 * circumradius(item.shape, item.scale)) ** 2 for item in map_spec.items)
    return Storage(map_spec, depth, inside, covered / area > _ROOMY)


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """What putting a disc down does to the floor, for a coarse choice of places."""

    number: npt.NDArray[np.int64]  # (CELLS, CELLS) the place nearest to a cell of the goal regions
    price: Floats  # (n,)
    ways_out: Mask  # (n, CELLS, CELLS) from where a robot still gets about


@lru_cache(maxsize=32)
def places(ground: Terrain, radius: float, outlook: Outlook) -> Places:
    """Look into every place for a disc of this radius."""
    inside = storage(ground.map).inside
    rows, columns = np.nonzero(inside)
    spacing = 2 + len(rows) // 250  # cells: about a hundred places in all
    coarse = (rows // spacing) * CELLS + columns // spacing
    _, firsts, numbers = np.unique(coarse, return_index=True, return_inverse=True)
    number = np.full((CELLS, CELLS), -1, dtype=np.int64)
    number[rows, columns] = numbers
    free = standing_room(ground, ROBOT_RADIUS)
    marks = [mark for mark in (_around(x, y, 0.36) & free for x, y in outlook.points) if mark]
    together = _joined(free, marks)
    centres = _centres(rows, columns, numbers)
    price = _room_taken(ground, centres, radius, outlook.largest)
    ways_out = np.zeros((len(firsts), CELLS, CELLS), dtype=np.bool_)
    for place in range(len(firsts)):
        x, y = centres[place].tolist()
        left = free & ~_around(x, y, radius + ROBOT_RADIUS)
        reached = flood(together[0] & left, left) if together else left
        if any(not mark & reached for mark in together[1:]):
            price[place] += _CUTS
        ways_out[place] = to_mask(grown(reached, 3))
    return Places(number, price, ways_out)


def _centres(rows: Cells, columns: Cells, numbers: Cells) -> Floats:
    """(n, 2) x, y of the middle cell of each place."""
    count = np.bincount(numbers)
    x = np.rint(np.bincount(numbers, columns) / count).astype(np.int64)
    y = np.rint(np.bincount(numbers, rows) / count).astype(np.int64)
    return np.stack([AXIS[x], AXIS[y]], axis=1)


def _room_taken(ground: Terrain, centres: Floats, radius: float, largest: float) -> Floats:
    """(n,) the price of leaving little room for the largest item to come."""
    if largest <= 0.0:
        return np.zeros(len(centres))
    needed = largest + 0.02
    x, y = centres[:, 0], centres[:, 1]
    fits = sample(ground.clearance, x, y) >= needed
    inside = np.zeros(len(centres), dtype=np.bool_)
    for left, bottom, right, top in goal_boxes(ground.map):
        inside |= (x > left + largest) & (x < right - largest) & (y > bottom + largest) & (y < top - largest)
    gaps = np.hypot(x[:, None] - x, y[:, None] - y)
    room = ((gaps >= radius + needed) & fits & inside).sum(axis=1)
    return np.asarray(_ROOM * (1.0 - room / max(int(room.max()), 1)))


def _joined(free: int, marks: list[int]) -> list[int]:
    """Those marks that hang together with the first one."""
    if not marks:
        return []
    reached = flood(marks[0], free)
    return [mark for mark in marks if mark & reached]


@lru_cache(maxsize=4096)
def _around(x: float, y: float, radius: float) -> int:
    grid_x, grid_y = np.meshgrid(AXIS, AXIS)
    return to_bits(np.hypot(grid_x - x, grid_y - y) < radius)


def place_costs(
    ground: Terrain,
    motion: Motion,
    offset: Point,
    extents: Floats,
    radius: float,
    robots: list[Point],
    outlook: Outlook,
) -> Cost:
    """Start costs (headings, CELLS, CELLS) of putting an item down, for `Field.seed`.

    `offset` is the item's centre and `robots` are the robots' in the frame of the body's reference point; `extents`
    (headings, 2) are half the width and height of its bounding box. Poses that do not deliver it are UNREACHED.
    """
    angles = np.arange(motion.headings) * 2 * np.pi / motion.headings
    x, y = moved(offset, angles)
    inside = np.zeros((motion.headings, CELLS, CELLS), dtype=np.bool_)
    for left, bottom, right, top in goal_boxes(ground.map):
        wide, high = extents[:, 0, None, None] + _INSET, extents[:, 1, None, None] + _INSET
        inside |= (x > left + wide) & (x < right - wide) & (y > bottom + high) & (y < top - high)
    heading, row, column = np.nonzero(inside)
    item = cells(x[heading, 0, column], y[heading, row, 0])
    look = places(ground, round(radius, 3), outlook)
    number = look.number[item]
    cost = _preference(ground, item) + look.price[number]
    for robot in robots:
        rx, ry = moved(robot, angles)
        where = cells(rx[heading, 0, column], ry[heading, row, 0])
        cost = cost + np.where(look.ways_out[number, where[0], where[1]], 0.0, _SHUT_IN)
    costs = np.full(inside.shape, UNREACHED, dtype=np.int16)
    costs[inside] = np.where(number < 0, UNREACHED, cost).astype(np.int16)
    return costs


def moved(offset: Point, angles: Floats) -> tuple[Floats, Floats]:
    """x (headings, 1, CELLS) and y (headings, CELLS, 1) of a point of the body for every reference point."""
    dx = offset[0] * np.cos(angles) - offset[1] * np.sin(angles)
    dy = offset[0] * np.sin(angles) + offset[1] * np.cos(angles)
    return AXIS[None, None, :] + dx[:, None, None], AXIS[None, :, None] + dy[:, None, None]


def cells(x: Floats, y: Floats) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    rows = np.rint((y - AXIS[0]) / CELL).astype(np.int64)
    columns = np.rint((x - AXIS[0]) / CELL).astype(np.int64)
    return np.clip(rows, 0, CELLS - 1), np.clip(columns, 0, CELLS - 1)


def _preference(ground: Terrain, item: tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]) -> Floats:
    store = storage(ground.map)
    if not store.crowded:
        return np.asarray(0.25 * (store.depth.max() - store.depth[item]))
    shallow = _EAGER * (store.depth.max() - store.depth[item])
    return np.asarray(shallow + _COMPACT * np.clip(ground.clearance[item], 0.0, 0.3))
