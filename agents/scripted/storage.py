"""Where in the goal regions an item is best put down, so that every other item still finds its place.

Three rules, as prices on places: far in before near the edge where room is scarce; never where it would cut the
floor in two or shut a robot in; close to walls and to what lies there already.
"""

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.scripted.flood import Mask, flood, grown, standing_room, to_bits, to_mask
from agents.scripted.lattice import UNREACHED, Cost, Field, Motion
from agents.scripted.terrain import AXIS, CELL, CELLS, Terrain, terrain
from agents.scripted.thinking import Thinking, Thought
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
_DENSE = 0.25  # share from which on places matter ever more
_EAGER = 1.3  # quarter ticks per quarter tick of depth, where room is scarce
_COMPACT = 60.0  # quarter ticks per unit of free space around a place
_OUT_OF_REACH = 150  # quarter ticks for each item that nobody would reach any more
_SHUT_IN = 600  # quarter ticks: the robot could not get out again
_BESIDE = 0.36  # units around an item from which it counts as within reach
_ON_SLOT = 0.06  # units from a slot that still are on it
_PRECISION = 300.0  # quarter ticks per unit off the middle of a slot
_OFF_SLOT = 220.0  # quarter ticks: the price of any other place
_SLOT_ORDER = 3.0  # quarter ticks per quarter tick of depth: the deep slots first
_REMEMBERED = 32  # looks of all players
_REMEMBERED_BY_ONE = 4
_PLACES_PER_SLICE = 8
_ARM = 8  # cells between a robot's centre and that of an item it puts down
_ELBOWS = 0.1  # units of room that two robots want around what they put down
_ABREAST = (0.1, 0.05, 0.02)  # units of room on both sides of a heavy item on its way, the best first
_SMALL = 0.09  # radius up to which an item is a small one
_CHOICE = 120.0  # quarter ticks for taking all the places that the largest item to come can choose from
_MISFIT = 120.0  # quarter ticks for each item to come that finds no place any more


class Outlook(NamedTuple):
    """What is still to be delivered besides an item, and who else can do it."""

    small: tuple[Point, ...]  # where items wait that one robot can carry
    heavy: tuple[Point, ...]  # and those that need both
    sizes: tuple[float, ...]  # radii of all the items to come, the largest first
    partner: Point | None  # the robot that does not hold the item in question; None when both hold it


@dataclass(frozen=True, slots=True, eq=False)
class Storage:
    """The goal regions of a map. `depth` (CELLS, CELLS) is the way out of the region, in quarter ticks."""

    map: MapSpec
    depth: Floats
    inside: Mask
    slots: Floats  # (n, 2) planned places, far apart, where only small items come and room is scarce; else none
    crowding: float  # 0 where there is room, else how much places matter: 1 and more


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
    radii = [circumradius(item.shape, item.scale) for item in map_spec.items]
    share = sum((2 * radius) ** 2 for radius in radii) / area
    crowding = min(max(share / _DENSE, 1.0), 3.0) if share > _ROOMY else 0.0
    planned = crowding > 0.0 and all(item.size == "small" for item in map_spec.items)
    slots = _slots(map_spec, depth, sum(radii) / len(radii), len(radii)) if planned else np.empty((0, 2))
    return Storage(map_spec, depth, inside, slots, crowding)


def _slots(map_spec: MapSpec, depth: Floats, radius: float, number: int) -> Floats:
    """(number, 2) places as far from each other as they can be, beginning in the depth of the goal regions."""
    x, y = np.meshgrid(AXIS, AXIS)
    room = terrain(map_spec, ()).clearance >= radius + 0.004
    rows, columns = np.nonzero(room & _within_goals(map_spec, x, y, radius + _INSET))
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


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """What putting a disc down does to the floor, for a coarse choice of places."""

    number: Cells  # (CELLS, CELLS) the place nearest to a cell of the goal regions, -1 elsewhere
    price: Floats  # (n,) of the place itself
    lost: npt.NDArray[np.int16]  # (n, CELLS, CELLS) besides, for a robot that then stands at a cell


Look = tuple[Terrain, float, Outlook]
_known: OrderedDict[Look, Places] = OrderedDict()


class Looks:
    """What one player looks into: what it looked into lately takes no time again.

    The players of a process share what they find, not the time for it: how long one thinks follows from what it has
    seen itself, so that an episode goes the same way in any company.
    """

    def __init__(self) -> None:
        self._lately: list[Look] = []

    def places(self, ground: Terrain, radius: float, outlook: Outlook) -> Thought[Places]:
        """Look into every place for a disc of this radius."""
        look = (ground, round(radius, 3), outlook)
        if look in self._lately:
            return _found(look)
        if look in _known:
            for _ in range(-(-len(_known[look].price) // _PLACES_PER_SLICE)):  # as many slices as `_look_into` takes
                yield
        else:
            _keep(look, (yield from _look_into(*look)))
        self._lately = [*self._lately, look][-_REMEMBERED_BY_ONE:]
        return _found(look)


def _found(look: Look) -> Places:
    if look not in _known:  # forgotten, since the others looked into so much
        thinking = Thinking(_look_into(*look))
        while not thinking.done:
            thinking.advance(_PLACES_PER_SLICE)
        _keep(look, thinking.result)
    return _known[look]


def _keep(look: Look, found: Places) -> None:
    _known[look] = found
    while len(_known) > _REMEMBERED:
        _known.popitem(last=False)


def _look_into(ground: Terrain, radius: float, outlook: Outlook) -> Thought[Places]:
    inside = storage(ground.map).inside
    rows, columns = np.nonzero(inside)
    spacing = 2 + len(rows) // 250  # cells: about a hundred places in all
    coarse = (rows // spacing) * CELLS + columns // spacing
    _, numbers = np.unique(coarse, return_inverse=True)
    number = np.full((CELLS, CELLS), -1, dtype=np.int64)
    number[rows, columns] = numbers
    centres = _centres(rows, columns, numbers)
    free = standing_room(ground, ROBOT_RADIUS)
    before = _best_case(free, outlook)
    partner_free = _partner_gets_about(free, _parts(free, outlook), outlook)
    lost = np.zeros((len(centres), CELLS, CELLS), dtype=np.int16)
    misfits, choice = np.zeros(len(centres)), np.zeros(len(centres))
    packing = None if len(storage(ground.map).slots) else _Packing(ground, outlook)
    for place, (x, y) in enumerate(centres.tolist()):
        left = free & ~_around(x, y, radius + ROBOT_RADIUS)
        parts = _parts(left, outlook)
        lost[place] = _lost(left, parts, outlook, before)
        if partner_free and not _partner_gets_about(left, parts, outlook):
            lost[place] += _SHUT_IN // 2
        if packing is not None:
            reach = _arms_reach(left, parts, outlook)
            misfits[place], choice[place] = packing.try_all(x, y, radius, reach)
        if place % _PLACES_PER_SLICE == 0:
            yield
    crowd_out = _MISFIT * (misfits - misfits.min(initial=len(outlook.sizes)))
    return Places(number, crowd_out + _CHOICE * (1.0 - choice / max(float(choice.max(initial=1.0)), 1.0)), lost)


def _partner_gets_about(free: int, parts: list[int], outlook: Outlook) -> bool:
    """Whether the other robot can still go to an item."""
    if outlook.partner is None:
        return True
    place = _around(*outlook.partner, 0.15)
    return any(place & part for part in parts)


def _arms_reach(left: int, parts: list[int], outlook: Outlook) -> Mask:
    """Where items can be put down by robots that still get about."""
    whole = 0 if outlook.partner is None else flood(_around(*outlook.partner, 0.15) & left, left)
    for part in parts:
        whole |= part
    return to_mask(grown(whole, _ARM))


def _best_case(free: int, outlook: Outlook) -> int:
    """How many items are out of reach at least, whatever is done."""
    return min((_out_of_reach(part, free, outlook) for part in _parts(free, outlook)), default=0)


def _lost(left: int, parts: list[int], outlook: Outlook, before: int) -> npt.NDArray[np.int16]:
    """(CELLS, CELLS) the price of the items that get out of reach, for a robot that stands at a cell."""
    stuck = len(outlook.small) + len(outlook.heavy)
    price = np.full((CELLS, CELLS), _SHUT_IN if stuck else 0.0, dtype=np.int16)
    for part in parts:
        missed = max(_out_of_reach(part, left, outlook) - before, 0)
        price[to_mask(grown(part, 3))] = min(missed * _OUT_OF_REACH, _SHUT_IN)
    return price


def _parts(free: int, outlook: Outlook) -> list[int]:
    """The separate parts of the floor that have an item beside them."""
    parts: list[int] = []
    for x, y in (*outlook.small, *outlook.heavy):
        beside = _around(x, y, _BESIDE) & free
        for part in parts:
            beside &= ~part
        while beside:
            part = flood(beside & -beside, free)
            parts.append(part)
            beside &= ~part
    return parts


def _out_of_reach(part: int, free: int, outlook: Outlook) -> int:
    """How many items cannot be reached by a robot in this part of the floor and its partner."""
    theirs = part if outlook.partner is None else flood(_around(*outlook.partner, 0.15) & free, free)
    missed = sum(not _around(x, y, _BESIDE) & (part | theirs) for x, y in outlook.small)
    for x, y in outlook.heavy:
        beside = _around(x, y, _BESIDE)
        missed += not (beside & part and beside & theirs)
    return missed


def _centres(rows: Cells, columns: Cells, numbers: Cells) -> Floats:
    """(n, 2) x, y of the middle cell of each place."""
    count = np.bincount(numbers)
    x = np.rint(np.bincount(numbers, columns) / count).astype(np.int64)
    y = np.rint(np.bincount(numbers, rows) / count).astype(np.int64)
    return np.stack([AXIS[x], AXIS[y]], axis=1)


class _Packing:
    """Tries whether the items to come still find places, one after the other, the largest first, deep places first."""

    def __init__(self, ground: Terrain, outlook: Outlook) -> None:
        sizes = outlook.sizes
        self._heavy = outlook.heavy
        store = storage(ground.map)
        rows, columns = np.nonzero(store.inside & (ground.clearance > 0.0))
        order = np.lexsort((ground.clearance[rows, columns], -store.depth[rows, columns]))
        self._cells = rows[order], columns[order]
        self._x, self._y = AXIS[columns[order]], AXIS[rows[order]]
        self._room = ground.clearance[self._cells]
        self._gaps = np.hypot(self._x[:, None] - self._x, self._y[:, None] - self._y)
        self._sizes = sizes
        self._fits = {size: _within_goals(ground.map, self._x, self._y, size) for size in set(sizes)}
        self._wide = {size: self._ways(ground, size) for size in set(sizes) if size > _SMALL}

    def try_all(self, x: float, y: float, radius: float, arms_reach: Mask) -> tuple[int, int]:
        """How many find no place once a disc lies at (x, y), and how many places the largest has to choose from."""
        left = np.minimum(self._room, np.hypot(self._x - x, self._y - y) - radius)
        reached = arms_reach[self._cells]
        missing, choice = 0, -1
        for size in self._sizes:
            if size <= _SMALL:
                possible = self._fits[size] & reached & (left >= size + 0.01)
            else:
                way = self._carried(x, y, radius, size)
                possible = self._fits[size] & way & (left >= size + _ELBOWS)
            choice = int(possible.sum()) if choice < 0 else choice
            first = int(np.argmax(possible)) if possible.size else 0
            if possible.size and possible[first]:
                left = np.minimum(left, self._gaps[first] - size)
            else:
                missing += 1
        return missing, max(choice, 0)

    def _ways(self, ground: Terrain, size: float) -> tuple[float, int, int]:
        """How much room a heavy item's way can have now, the floor with that room, and where the way starts."""
        start = 0
        for point in self._heavy:
            start |= _around(*point, 2 * size + 0.2)  # the item itself still stands there
        for abreast in _ABREAST:
            wide = standing_room(ground, size + abreast)
            if (to_mask(flood(start & wide, wide))[self._cells] & self._fits[size]).any():
                return abreast, wide, start & wide
        return 0.0, 0, 0

    def _carried(self, x: float, y: float, radius: float, size: float) -> npt.NDArray[np.bool_]:
        """(n,) which cells a heavy item still gets to with a disc at (x, y)."""
        abreast, wide, start = self._wide[size]
        if not wide:
            return np.ones(self._x.shape, dtype=np.bool_)
        left = wide & ~_around(x, y, radius + size + abreast)
        return to_mask(flood(start & left, left))[self._cells]


def _within_goals(map_spec: MapSpec, x: Floats, y: Floats, radius: float) -> npt.NDArray[np.bool_]:
    """Whether discs lie within a goal region; their outermost tenth may be a tip that looks elsewhere."""
    inside = np.zeros(x.shape, dtype=np.bool_)
    size = 0.9 * radius
    for left, bottom, right, top in goal_boxes(map_spec):
        inside |= (x > left + size) & (x < right - size) & (y > bottom + size) & (y < top - size)
    return inside


@lru_cache(maxsize=4096)
def _around(x: float, y: float, radius: float) -> int:
    grid_x, grid_y = np.meshgrid(AXIS, AXIS)
    return to_bits(np.hypot(grid_x - x, grid_y - y) < radius)


def place_costs(
    ground: Terrain,
    motion: Motion,
    offset: Point,
    extents: Floats,
    robots: list[Point],
    look: Places,
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
    number = look.number[item]
    where_item = np.stack([x[heading, 0, column], y[heading, row, 0]], axis=1)
    cost = _preference(ground, item, where_item) + look.price[number]
    for robot in robots:
        rx, ry = moved(robot, angles)
        where = cells(rx[heading, 0, column], ry[heading, row, 0])
        cost = cost + look.lost[number, where[0], where[1]] / len(robots)
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


def _preference(ground: Terrain, item: tuple[Cells, Cells], points: Floats) -> Floats:
    """(k,) prices of places, given as cells and as points (k, 2)."""
    store = storage(ground.map)
    if not store.crowding:
        return np.asarray(0.25 * (store.depth.max() - store.depth[item]))
    if len(store.slots):
        gaps = np.hypot(*(points[:, None, :] - store.slots).transpose(2, 0, 1))
        depths = store.depth[cells(store.slots[:, 0], store.slots[:, 1])]
        order = _SLOT_ORDER * (depths.max() - depths)[gaps.argmin(axis=1)]
        off = gaps.min(axis=1)
        return np.asarray(np.where(off <= _ON_SLOT, order + _PRECISION * off, _OFF_SLOT))
    shallow = _EAGER * (store.depth.max() - store.depth[item])
    return np.asarray(store.crowding * (shallow + _COMPACT * np.clip(ground.clearance[item], 0.0, 0.3)))
