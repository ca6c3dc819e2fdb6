"""Collision avoidance between the robots: predicting the partner's path, and moving out of it."""

import math
from functools import lru_cache

import numpy as np

from movingout.agents.scripted.carrying.solo_carry import DrivePlan, carried_discs
from movingout.agents.scripted.navigation.cost_search import Search
from movingout.agents.scripted.navigation.free_space import AXIS, CELLS, FLOOR, FreeSpace, cell_of, sample, with_robot
from movingout.agents.scripted.navigation.geometry import Disc, heading_of
from movingout.agents.scripted.navigation.grasp_stance import HEADINGS, in_frame
from movingout.agents.scripted.navigation.motion_choice import HORIZON, STRIDE, CollisionCost, no_collision_cost
from movingout.agents.scripted.navigation.pose_grid import SOLO_MOTION
from movingout.agents.scripted.navigation.walking_route import WalkingRoute, route_to
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.goal_storage import goal_storage
from movingout.maps import MapSpec
from movingout.maps.flood_fill import UNREACHED, Mask
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.constants import TICK_SECONDS
from movingout.world.state import Floats

_TOUCHING = 0.09  # units between two bodies; nearer ones count as in contact
_CLEAR = 0.29  # units between the own centre and the partner's path when standing aside
_MARGIN = 0.004  # units of clearance while standing aside
_SOON = 25  # cells of the own path that are checked
_BEGINNING = 12  # cells of a path that determine its direction
_SWING = 0.17  # additional units for a partner that must turn with an item
_CRAMPED = 80  # quarter ticks of walking that this additional room is worth
_FORESEEN = 70  # cells of the partner's path that are kept free
_WRONG_SIDE = 50.0  # quarter ticks of walking that the preferred side to grab from is worth
_MEETING_PRICE = 600.0  # quarter ticks per unit of overlap with the partner


def partner_collision_cost(now: Perception) -> CollisionCost:
    """The cost of short moves that come too near to the partner or its item, assuming its velocity stays the same."""
    steps = np.arange(1, HORIZON + 1)
    velocity = now.state.robot_velocities[1 - now.seat][:2] * TICK_SECONDS
    circles = [(now.partner[:2], ROBOT_RADIUS)]
    if now.partner_item >= 0 and not now.is_heavy(now.partner_item):
        circles.append((now.item_pose(now.partner_item)[:2], now.item(now.partner_item).scale))
    own = [(0.0, 0.0, ROBOT_RADIUS)]
    if now.own_item >= 0:
        own += carried_discs(now.item(now.own_item), in_frame(now.pose, now.item_pose(now.own_item)))
    longest = HORIZON * (STRIDE + float(np.hypot(*velocity)))  # that both robots move
    widest = max(math.hypot(x, y) + radius for x, y, radius in own) + 0.03
    if all(float(np.hypot(*(centre - now.pose[:2]))) > longest + widest + radius for centre, radius in circles):
        return no_collision_cost

    def collision_cost(moves: Floats) -> Floats:
        worst = np.zeros(moves.shape[:2])
        cos, sin = np.cos(moves[..., 2]), np.sin(moves[..., 2])
        for centre, radius in circles:
            x, y = centre[0] + velocity[0] * steps, centre[1] + velocity[1] * steps
            for dx, dy, own_radius in own:
                gap = np.hypot(moves[..., 0] + cos * dx - sin * dy - x, moves[..., 1] + sin * dx + cos * dy - y)
                worst = np.maximum(worst, radius + own_radius + 0.02 - gap)
        return np.asarray(_MEETING_PRICE * worst.max(axis=1))

    return collision_cost


def in_contact(now: Perception) -> bool:
    """Whether the robots, or what they carry, are so near that they block each other."""
    bodies = []
    for seat, held in ((now.seat, now.own_item), (1 - now.seat, now.partner_item)):
        x, y, _ = now.robots[seat].tolist()
        discs = [(x, y, ROBOT_RADIUS)]
        if held >= 0:
            ix, iy, _ = now.item_pose(held).tolist()
            discs.append((ix, iy, now.item(held).scale))
        bodies.append(discs)
    return any(
        math.hypot(ax - bx, ay - by) - ar - br < _TOUCHING for ax, ay, ar in bodies[0] for bx, by, br in bodies[1]
    )


def lower_bound(now: Perception, item: int) -> float:
    """A lower bound of the quarter ticks to deliver an item: the path of a single robot."""
    x, y, _ = now.item_pose(item).tolist()
    return _route_home(now.space((item,))).cost(x, y)


def partner_path(now: Perception, target: int, cells: int = _FORESEEN) -> Floats:
    """(n, 2) the predicted path of the partner, at most `cells` long.

    It leads to the goal with a small item that it carries, else to the item `target` (-1: it stays).
    """
    x, y = float(now.partner[0]), float(now.partner[1])
    if now.partner_item >= 0 and not now.is_heavy(now.partner_item):
        return _route_home(now.space()).path(x, y, cells)
    if now.partner_item < 0 and target >= 0:
        goal = now.item_pose(target)
        return _route_to(now.space(), round(float(goal[0]), 2), round(float(goal[1]), 2)).path(x, y, cells)
    return np.array([[x, y]])


def exit_path(now: Perception, lane: Mask, target: int) -> Floats | None:
    """(n, 2) the path of a partner that is leaving a lane the own robot is about to enter, else None.

    The robot outside can wait; the one inside has no other path.
    """
    partner = cell_of(float(now.partner[0]), float(now.partner[1]))
    leaving = goal_area(now.map)[partner] or (lane[partner] and now.partner_item < 0)
    if target < 0 or not leaving:
        return None
    space = now.space()
    mine = _route_home(space).path(float(now.pose[0]), float(now.pose[1]), _SOON)
    if not any(lane[cell_of(x, y)] for x, y in mine.tolist()):
        return None
    goal = now.item_pose(target)
    route = _route_to(space, round(float(goal[0]), 2), round(float(goal[1]), 2))
    return route.path(float(now.partner[0]), float(now.partner[1]), _FORESEEN)


def side_costs(now: Perception, item: int, side: float) -> list[float]:
    """Cost in quarter ticks of each of the 32 stances around an item, for a preferred `side` to grab from.

    The side is 1 for behind and -1 for ahead, along the beginning of the item's path to the goal.
    """
    if side == 0.0:
        return [0.0] * len(HEADINGS)
    x, y, _ = now.item_pose(item).tolist()
    path = _route_home(now.space((item,))).path(x, y, _BEGINNING)
    home = heading_of(float(path[-1, 0] - x), float(path[-1, 1] - y))
    prices: list[float] = (_WRONG_SIDE * (abs(side) - side * np.cos(HEADINGS - home)) / 2).tolist()
    return prices


@lru_cache(maxsize=32)
def _route_home(space: FreeSpace) -> WalkingRoute:
    near = FLOOR.to_mask(FLOOR.dilated(FLOOR.to_bits(goal_storage(space.map).inside), 3)) & (
        space.clearance > ROBOT_RADIUS
    )
    rows, columns = np.nonzero(near)
    return route_to(space, [(float(AXIS[c]), float(AXIS[r])) for r, c in zip(rows[::7], columns[::7], strict=True)])


@lru_cache(maxsize=32)
def _route_to(space: FreeSpace, x: float, y: float) -> WalkingRoute:
    return route_to(space, [(x, y)])


@lru_cache(maxsize=64)
def goal_area(map_spec: MapSpec) -> Mask:
    """(CELLS, CELLS) where an idle robot would block a delivery."""
    return FLOOR.to_mask(FLOOR.dilated(FLOOR.to_bits(goal_storage(map_spec).inside), 5))


def meeting_cells(path: Floats) -> Mask:
    """(CELLS, CELLS) where a robot would collide with one that follows a path (n, 2)."""
    x, y = np.meshgrid(AXIS, AXIS)
    return distance_to_path(path, x, y) < 2 * ROBOT_RADIUS


def distance_to_path(path: Floats, x: Floats, y: Floats) -> Floats:
    """Distance from points to the nearest point of a path (n, 2)."""
    gaps = np.full(x.shape, 9.0)
    for px, py in (*path[::3], *path[-1:]):
        np.minimum(gaps, np.hypot(x - px, y - py), out=gaps)
    return gaps


def step_aside_plan(now: Perception, path: Floats) -> DrivePlan:
    """A plan to drive, with what the robot holds, to the nearest pose that leaves the partner's path free."""
    discs = [(0.0, 0.0, ROBOT_RADIUS)]
    if now.own_item >= 0:
        discs += carried_discs(now.item(now.own_item), in_frame(now.pose, now.item_pose(now.own_item)))
    space = with_robot(now.space(), now.partner)
    carrying = now.partner_item >= 0 and not goal_area(now.map)[cell_of(float(now.partner[0]), float(now.partner[1]))]
    search = _search_aside(space, tuple(discs), path.tobytes(), carrying, now.own_item < 0)
    return DrivePlan(space, discs, search)


@lru_cache(maxsize=4)  # a robot that is still in the way asks for the same search again
def _search_aside(space: FreeSpace, discs: tuple[Disc, ...], path: bytes, roomy: bool, off_goal: bool) -> Search:
    """The search for a pose off a path (n, 2); `roomy` prefers one with more room, `off_goal` excludes the goals."""
    x, y = np.meshgrid(AXIS, AXIS)
    clear = distance_to_path(np.frombuffer(path).reshape(-1, 2), x, y)
    if off_goal:
        clear = np.where(goal_area(space.map), 0.0, clear)
    costs = np.full((SOLO_MOTION.headings, CELLS, CELLS), UNREACHED, dtype=np.int16)
    free, spacious = clear >= _CLEAR, clear >= _CLEAR + _SWING
    for heading in range(SOLO_MOTION.headings):
        angle = heading * 2 * math.pi / SOLO_MOTION.headings
        here = free.copy()
        for dx, dy, radius in discs[1:]:
            at_x = x + dx * math.cos(angle) - dy * math.sin(angle)
            at_y = y + dx * math.sin(angle) + dy * math.cos(angle)
            here &= sample(clear, at_x, at_y) >= ROBOT_RADIUS + radius + 0.03
        costs[heading][here] = _CRAMPED if roomy else 0
        costs[heading][here & spacious] = 0
    return Search(space, discs, SOLO_MOTION, _MARGIN, costs)
