"""Handover in lanes too narrow for two: one robot carries items to a handover point, the other on to the goal.

On a locked map the robots cannot pass each other, so the one nearer to the goal always stays nearer.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from movingout.agents.scripted.navigation.free_space import (
    AXIS,
    CELLS,
    FLOOR,
    FreeSpace,
    cell_of,
    free_space,
    standing_room,
)
from movingout.agents.scripted.navigation.pose_grid import Cost, MotionPrimitives
from movingout.agents.scripted.navigation.walking_route import WALKING, route_to
from movingout.agents.scripted.placement.goal_storage import cells, goal_storage, moved
from movingout.agents.scripted.placement.remaining_items import Point
from movingout.maps import MapSpec
from movingout.maps.flood_fill import UNREACHED, Mask
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

_LONG = 4  # places on the path that a lane has at least
_LOCKED_SHARE = 0.9  # share of the places on the path at which a robot blocks it
_STORING = 25.0  # quarter ticks that the robot near the goal needs additionally, into the goal and out again
_BAND = 14.0  # quarter ticks around the handover point within which an item may lie
FARTHEST = 0.8  # the largest share of the path to the goal at which items are handed over
_STANDOFF = 50.0  # quarter ticks between the handover point and the robot that waits for items


@dataclass(frozen=True, slots=True, eq=False)
class HandoverLane:
    """Handover on one map. `cost_to_goal` (CELLS, CELLS): path to the goals [quarter ticks]."""

    locked: bool
    last_lane: Mask  # (CELLS, CELLS) the lane just before the goal
    cost_to_goal: Floats
    handover: float  # quarter ticks from the goal to the handover point

    def left(self, pose: Floats) -> float:
        """Quarter ticks from a pose to the goal."""
        return float(self.cost_to_goal[cell_of(float(pose[0]), float(pose[1]))])

    def waiting_place(self) -> tuple[float, float]:
        """Where the robot near the goal waits for items."""
        gaps = np.abs(self.cost_to_goal - max(self.handover - _STANDOFF, 0.0))
        row, column = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
        return float(AXIS[column]), float(AXIS[row])

    def is_handed_over(self, item_pose: Floats) -> bool:
        """Whether an item lies where the robot near the goal fetches it."""
        return self.left(item_pose) <= self.handover + _BAND + 4.0


def handover_costs(plan: HandoverLane, motion: MotionPrimitives, offset: Point) -> Cost:
    """Start costs (headings, CELLS, CELLS) of putting an item down at the handover point, for a `Search`.

    `offset` is the item's centre in the robot's frame. The robot must be on its far side, off the path to the goal.
    """
    angles = np.arange(motion.headings) * 2 * np.pi / motion.headings
    x, y = moved(offset, angles)
    shape = (motion.headings, CELLS, CELLS)
    item = cells(np.broadcast_to(x, shape), np.broadcast_to(y, shape))
    left = plan.cost_to_goal[item]
    off = np.abs(left - plan.handover)
    behind = plan.cost_to_goal[None] > left + 4.0
    return np.where(off <= _BAND, 0.5 * off + np.where(behind, 0.0, 80.0), UNREACHED).astype(np.int16)


@lru_cache(maxsize=64)
def handover_lane(map_spec: MapSpec, handover: float) -> HandoverLane:
    """Whether and where items are handed over on a map, judged from the start of its first small item.

    `handover` is the share of the path to the goal that lies beyond the handover point.
    """
    bare = free_space(map_spec, ())
    cost_to_goal = FLOOR.path_lengths(
        FLOOR.to_bits(goal_storage(map_spec).inside), standing_room(bare, 0.06), WALKING
    ).astype(np.float64)
    small = next((item for item in map_spec.items if item.size == "small"), None)
    if small is None:
        return HandoverLane(False, np.zeros((CELLS, CELLS), dtype=np.bool_), cost_to_goal, 0.0)
    start = (small.pose.x, small.pose.y)
    whole = float(cost_to_goal[cell_of(*start)])
    places, blocked = _bottlenecks(bare, start)
    locked = len(places) >= _LONG and float(blocked.mean()) >= _LOCKED_SHARE
    return HandoverLane(locked, _last_lane(places, blocked), cost_to_goal, max((whole - _STORING) * handover, 0.0))


def _bottlenecks(bare: FreeSpace, start: Point) -> tuple[Floats, Mask]:
    """Places (n, 2) on the path from an item to the goal, and at which of them a robot blocks every path."""
    inside = goal_storage(bare.map).inside
    free = standing_room(bare, ROBOT_RADIUS + 0.004)
    goal = FLOOR.to_bits(inside) & free
    rows, columns = np.nonzero(inside & (bare.clearance > ROBOT_RADIUS))
    if not len(rows):
        return np.empty((0, 2)), np.empty(0, dtype=np.bool_)
    middle = len(rows) // 2
    path = route_to(bare, [(float(AXIS[columns[middle]]), float(AXIS[rows[middle]]))]).path(*start, 400)
    x, y = np.meshgrid(AXIS, AXIS)
    home = np.zeros((CELLS, CELLS), dtype=np.bool_)
    home[cell_of(float(path[0, 0]), float(path[0, 1]))] = True
    places = path[14:-14:4]
    blocked = []
    for px, py in places:
        left = free & ~FLOOR.to_bits(np.hypot(x - px, y - py) < 2 * ROBOT_RADIUS)
        blocked.append(not FLOOR.connected(FLOOR.to_bits(home) & left, left) & goal)
    return places, np.array(blocked, dtype=np.bool_)


def _last_lane(places: Floats, blocked: Mask) -> Mask:
    """(CELLS, CELLS) the unavoidable part of the path just before the goal."""
    x, y = np.meshgrid(AXIS, AXIS)
    lane = np.zeros((CELLS, CELLS), dtype=np.bool_)
    for (px, py), blocks in zip(places[::-1].tolist(), blocked[::-1].tolist(), strict=True):
        if not blocks:
            break
        lane |= np.hypot(x - px, y - py) < 2 * ROBOT_RADIUS
    return lane
