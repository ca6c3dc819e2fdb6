"""The costs of places for an item in the goals, such that all other items still find a place.

Three rules: deep places before those near the edge where room is scarce; no place that would divide the free space or
trap a robot; places close to walls and to items before open ones.
"""

from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import AXIS, CELLS, FLOOR, FreeSpace, standing_room
from movingout.agents.scripted.navigation.pose_grid import Cost, MotionPrimitives
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation
from movingout.agents.scripted.placement.goal_storage import EXACT_CROWDING, INSET, cells, goal_storage, moved
from movingout.agents.scripted.placement.packing import Packing
from movingout.agents.scripted.placement.remaining_items import Point, ReachableRegions, RemainingItems, disc_points
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.scoring import goal_boxes
from movingout.world.state import Floats

Cells = npt.NDArray[np.int64]

_DEPTH_COST = 1.3  # quarter ticks per quarter tick of depth, where room is scarce
_OPENNESS_COST = 60.0  # quarter ticks per unit of free space around a place
_ON_SLOT = 0.06  # units within which an item is on a slot
_PRECISION = 300.0  # quarter ticks per unit off the centre of a slot
_OFF_SLOT = 220.0, 420.0  # quarter ticks for any other place; where all must fit exactly
_SLOT_ORDER = 3.0, 10.0  # quarter ticks per quarter tick of depth; where all must fit exactly
_UNREACHABLE_COST = 150  # quarter ticks for each item that no robot could reach any more
_TRAPPED_COST = 600  # quarter ticks for a place where the robot would be trapped
_CACHED = 32  # evaluations of all agents
_CACHED_BY_ONE = 4  # by each agent
_PLACES_PER_SLICE = 8
_CHOICE_COST = 120.0  # quarter ticks for leaving the largest remaining item no choice of places
_MISFIT_COST = 120.0  # quarter ticks for each remaining item without a place


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The effect of putting a disc down, for a coarse set of places."""

    number: Cells  # (CELLS, CELLS) the place of each cell of the goals, -1 elsewhere
    cost: Floats  # (n,) cost of the place itself
    reach_cost: npt.NDArray[np.int16]  # (n, CELLS, CELLS) additional cost for a robot that is then at a cell


PlacementQuery = tuple[FreeSpace, float, RemainingItems]
_cache: OrderedDict[PlacementQuery, Places] = OrderedDict()


class PlacementCache:
    """The places that one agent has evaluated recently; asking for them again takes no slices.

    The agents of a process share the results but not the time: the slices that an evaluation takes depend only on what
    the agent itself has evaluated, so that an episode does not depend on the others in the process.
    """

    def __init__(self) -> None:
        self._lately: list[PlacementQuery] = []

    def places(self, space: FreeSpace, radius: float, remaining: RemainingItems) -> Computation[Places]:
        """Evaluate all places for a disc of this radius."""
        query = (space, round(radius, 3), remaining)
        if query in self._lately:
            return _found(query)
        if query in _cache:
            for _ in range(-(-len(_cache[query].cost) // _PLACES_PER_SLICE)):  # as many slices as `_evaluate` takes
                yield
        else:
            _store(query, (yield from _evaluate(*query)))
        self._lately = [*self._lately, query][-_CACHED_BY_ONE:]
        return _found(query)


def _found(query: PlacementQuery) -> Places:
    if query not in _cache:  # dropped, because others have evaluated many
        computation = SlicedComputation(_evaluate(*query))
        while not computation.done:
            computation.advance(_PLACES_PER_SLICE)
        _store(query, computation.result)
    return _cache[query]


def _store(query: PlacementQuery, found: Places) -> None:
    _cache[query] = found
    while len(_cache) > _CACHED:
        _cache.popitem(last=False)


def _evaluate(space: FreeSpace, radius: float, remaining: RemainingItems) -> Computation[Places]:
    inside = goal_storage(space.map).inside
    rows, columns = np.nonzero(inside)
    spacing = 2 + len(rows) // 250  # cells, for about a hundred places in all
    coarse = (rows // spacing) * CELLS + columns // spacing
    _, numbers = np.unique(coarse, return_inverse=True)
    number = np.full((CELLS, CELLS), -1, dtype=np.int64)
    number[rows, columns] = numbers
    centres = _centres(rows, columns, numbers)
    free = standing_room(space, ROBOT_RADIUS)
    whole = ReachableRegions(free, remaining)
    before = whole.best_case()
    reach_cost = np.zeros((len(centres), CELLS, CELLS), dtype=np.int16)
    misfits, choice = np.zeros(len(centres)), np.zeros(len(centres))
    packing = None if len(goal_storage(space.map).slots) else Packing(space, remaining)
    for place, (x, y) in enumerate(centres.tolist()):
        left = ReachableRegions(free, remaining, disc_points(x, y, radius + ROBOT_RADIUS), whole)
        reach_cost[place] = _reach_costs(left, remaining, before)
        if whole.partner_can_work and not left.partner_can_work:
            reach_cost[place] += _TRAPPED_COST // 2
        if packing is not None:
            misfits[place], choice[place] = packing.place_all(x, y, radius, left.placeable())
        if place % _PLACES_PER_SLICE == 0:
            yield
    crowd_out = _MISFIT_COST * (misfits - misfits.min(initial=len(remaining.sizes)))
    return Places(
        number, crowd_out + _CHOICE_COST * (1.0 - choice / max(float(choice.max(initial=1.0)), 1.0)), reach_cost
    )


def _reach_costs(left: ReachableRegions, remaining: RemainingItems, before: int) -> npt.NDArray[np.int16]:
    """(CELLS, CELLS) the cost of items that become unreachable, for a robot at each cell."""
    stuck = len(remaining.small) + len(remaining.heavy)
    cost = np.full((CELLS, CELLS), _TRAPPED_COST if stuck else 0.0, dtype=np.int16)
    for part in left.parts:
        missed = max(left.out_of_reach(part) - before, 0)
        cost[FLOOR.to_mask(FLOOR.dilated(part, 3))] = min(missed * _UNREACHABLE_COST, _TRAPPED_COST)
    return cost


def _centres(rows: Cells, columns: Cells, numbers: Cells) -> Floats:
    """(n, 2) x, y of the middle cell of each place."""
    count = np.bincount(numbers)
    x = np.rint(np.bincount(numbers, columns) / count).astype(np.int64)
    y = np.rint(np.bincount(numbers, rows) / count).astype(np.int64)
    return np.stack([AXIS[x], AXIS[y]], axis=1)


def place_costs(
    space: FreeSpace,
    motion: MotionPrimitives,
    offset: Point,
    extents: Floats,
    robots: list[Point],
    places: Places,
    goal: int = -1,
) -> Cost:
    """Start costs (headings, CELLS, CELLS) of putting an item down, for a `Search`.

    `offset` is the item's centre and `robots` are the robots' in the frame of the body's reference point; `extents`
    (headings, 2) are half the width and height of its bounding box. `goal` is the only region to use, -1 for any. Poses
    that do not deliver the item are UNREACHED.
    """
    angles = np.arange(motion.headings) * 2 * np.pi / motion.headings
    x, y = moved(offset, angles)
    inside = np.zeros((motion.headings, CELLS, CELLS), dtype=np.bool_)
    boxes = goal_boxes(space.map)
    for left, bottom, right, top in boxes if goal < 0 else boxes[goal : goal + 1]:
        wide, high = extents[:, 0, None, None] + INSET, extents[:, 1, None, None] + INSET
        inside |= ((x > left + wide) & (x < right - wide)) & ((y > bottom + high) & (y < top - high))
    goals = np.flatnonzero(inside)
    row = goals // CELLS  # flat over (heading, row), as y is; where x is flat over (heading, column):
    column = row // CELLS * CELLS + goals % CELLS

    def cells_of(x: Floats, y: Floats) -> tuple[Cells, Cells]:
        rows, columns = cells(x.ravel(), y.ravel())
        return rows.take(row), columns.take(column)

    item = cells_of(x, y)
    number = places.number[item]
    where_item = np.stack([x.take(column), y.take(row)], axis=1)
    cost = _preference(space, item, where_item) + places.cost[number]
    for robot in robots:
        rows, columns = cells_of(*moved(robot, angles))
        cost = cost + places.reach_cost.take((number * CELLS + rows) * CELLS + columns) / len(robots)
    costs = np.full(inside.size, UNREACHED, dtype=np.int16)
    costs[goals] = np.where(number < 0, UNREACHED, cost).astype(np.int16)
    return costs.reshape(inside.shape)


def _preference(space: FreeSpace, item: tuple[Cells, Cells], points: Floats) -> Floats:
    """(k,) costs of places, given as cells and as points (k, 2)."""
    store = goal_storage(space.map)
    if not store.crowding:
        return np.asarray(0.25 * (store.depth.max() - store.depth[item]))
    if len(store.slots):
        gaps = np.hypot(*(points[:, None, :] - store.slots).transpose(2, 0, 1))
        depths = store.depth[cells(store.slots[:, 0], store.slots[:, 1])]
        crammed = store.crowding >= EXACT_CROWDING
        order = _SLOT_ORDER[crammed] * (depths.max() - depths)[gaps.argmin(axis=1)]
        off = gaps.min(axis=1)
        return np.asarray(np.where(off <= _ON_SLOT, order + _PRECISION * off, _OFF_SLOT[crammed]))
    shallow = _DEPTH_COST * (store.depth.max() - store.depth[item])
    return np.asarray(store.crowding * (shallow + _OPENNESS_COST * np.clip(space.clearance[item], 0.0, 0.3)))
