"""Carrying an item with two robots: one rigid body, moved by two robots that compute the same plan.

Both plan from the same visible state, so they need no communication. The reference point of the body is the item's
centre; its heading is the angle that the item has turned since both robots grabbed it.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.carrying.solo_carry import SETTLE_AFTER, StallCounter
from movingout.agents.scripted.navigation.cost_search import CostToGo, Search, shared_search
from movingout.agents.scripted.navigation.free_space import FreeSpace, overlap_cost
from movingout.agents.scripted.navigation.geometry import Disc, covering_discs, half_extents, heading_of, wrap
from movingout.agents.scripted.navigation.motion_choice import STRIDE, DriveCommand
from movingout.agents.scripted.navigation.pose_grid import PAIR_MOTION, UNIT_PER_TICK, costs_at_poses, nearest_cost
from movingout.agents.scripted.placement.goal_places import Places, place_costs
from movingout.maps import ItemSpec
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.constants import TOGETHER_TURN_DIVISOR
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats

EASY, TIGHT = 0.012, 0.002  # margins [u]
_SETTLED = 3.0
_TRIAL_TICKS = 3  # ticks of a trial motion
_TICKS = UNIT_PER_TICK * np.arange(1, _TRIAL_TICKS + 1)
_SPIN_PER_TICK = 0.16  # rad that two robots turn an item in a tick at most
_RELEASE = DriveCommand(0.0, 0.0, grasp=True)
_REMEMBERED_TWISTS = 8  # kept, because the partner asks for the same in the same tick


class Twist(NamedTuple):
    """The motion of the body in one tick."""

    dx: float
    dy: float
    turn: float


def _make_twists() -> Floats:
    rows = [(0.0, 0.0, sign * turn) for sign in (1, -1) for turn in (_SPIN_PER_TICK, _SPIN_PER_TICK / 2)]
    for number in range(16):
        angle = number * math.pi / 8
        for speed in (STRIDE, STRIDE / 3):
            for turn in (0.0, 0.09, -0.09):
                rows.append((speed * math.cos(angle), speed * math.sin(angle), turn))
    return np.array(rows)


_TWISTS = _make_twists()
_STEPS = np.arange(1, _TRIAL_TICKS + 1)[None, :, None]
_found: dict[tuple[Search, int, bytes], Twist] = {}  # by (search, level, pose)


class PairCarryPlan:
    """The plan for an item that both robots hold, or would hold with these grasps."""

    def __init__(
        self,
        space: FreeSpace,
        item: ItemSpec,
        item_pose: Floats,
        robots: Floats,
        places: Places,
        margin: float = EASY,
        goal: int = -1,
    ) -> None:
        """`robots` (2, 2+): positions while the item is at `item_pose`. `space` is without the item.

        `places`: the costs of places in the goals. `goal`: the only region to use, -1 for any.
        """
        self.item = item
        self._origin_angle = float(item_pose[2])
        self._goals = goal_boxes(space.map)
        self._space = space
        self._discs = _discs(item, item_pose, robots)
        self._search = _search(space, item, self._origin_angle, self._discs, places, margin, goal)
        self.cost_to_go = CostToGo(self._search)
        self._places = self._search.starts
        self._progress = StallCounter()

    @property
    def idle_ticks(self) -> int:
        """Ticks without progress."""
        return self._progress.ticks

    def cost(self, item_pose: Floats) -> float:
        """Quarter ticks from an item pose (3,)."""
        return float(costs_at_poses(self.cost_to_go.cost, PAIR_MOTION, self._body(item_pose)[None])[0])

    def drive(self, item_pose: Floats, robots: Floats) -> tuple[DriveCommand, DriveCommand]:
        """The next commands of both robots at poses (2, 3)."""
        body = self._body(item_pose)
        left = float(costs_at_poses(self.cost_to_go.cost, PAIR_MOTION, body[None])[0])
        if left >= UNREACHED and not self.cost_to_go.done:
            self.cost_to_go.search()
        settled = (
            self._progress.idle_ticks(left) >= SETTLE_AFTER
            or nearest_cost(self._places, PAIR_MOTION, body) <= left + _SETTLED
        )
        if settled and is_delivered(self.item, tuple(item_pose.tolist()), self._goals):
            return _RELEASE, _RELEASE
        return commands(self._best_twist(body), item_pose, robots)

    def _best_twist(self, body: Floats) -> Twist:
        """The best motion of the next tick, computed once for both robots."""
        asked = (self._search, self.cost_to_go.level, body.tobytes())
        if asked not in _found:
            if len(_found) >= _REMEMBERED_TWISTS:
                _found.clear()
            _found[asked] = self._look_for_twist(body)
        return _found[asked]

    def _look_for_twist(self, body: Floats) -> Twist:
        moves = body + _TWISTS[:, None, :] * _STEPS
        left = costs_at_poses(self.cost_to_go.cost, PAIR_MOTION, moves.reshape(-1, 3)).reshape(moves.shape[:2])
        through = (left + _TICKS).max(axis=1)
        pressed = overlap_cost(self._space, self._discs, moves).max(axis=1)
        best = _TWISTS[int(np.argmin(0.5 * (left[:, -1] + through) + pressed))]
        return Twist(*best.tolist())

    def _body(self, item_pose: Floats) -> Floats:
        return np.array([item_pose[0], item_pose[1], item_pose[2] - self._origin_angle])


@lru_cache(maxsize=32)
def _search(
    space: FreeSpace, item: ItemSpec, angle: float, discs: tuple[Disc, ...], places: Places, margin: float, goal: int
) -> Search:
    """`angle` is the item's at body heading 0; the last two discs are the robots."""
    turns = angle + np.arange(PAIR_MOTION.headings) * 2 * np.pi / PAIR_MOTION.headings
    extents = np.array([half_extents(item, float(turn)) for turn in turns])
    holders = [(x, y) for x, y, _ in discs[-2:]]
    return shared_search(
        space, discs, PAIR_MOTION, margin, place_costs(space, PAIR_MOTION, (0.0, 0.0), extents, holders, places, goal)
    )


def _discs(item: ItemSpec, item_pose: Floats, robots: Floats) -> tuple[Disc, ...]:
    cos, sin = math.cos(item_pose[2]), math.sin(item_pose[2])
    discs = [(cos * x - sin * y, sin * x + cos * y, radius) for x, y, radius in covering_discs(item)]
    for robot in robots:
        discs.append((float(robot[0] - item_pose[0]), float(robot[1] - item_pose[1]), ROBOT_RADIUS))
    return tuple(discs)


def commands(twist: Twist, item_pose: Floats, robots: Floats) -> tuple[DriveCommand, DriveCommand]:
    """The commands of two robots at poses (2, 3) that move the item by a twist.

    Each robot drives the way its own place in the body has to go. Ahead or backward is the same for the motion but
    not for the turn that the world adds (a tenth of the heading error, away from it): of the four choices the one
    is taken whose added turn is nearest to the wanted one.
    """
    steps = [
        (twist.dx - twist.turn * float(robot[1] - item_pose[1]), twist.dy + twist.turn * float(robot[0] - item_pose[0]))
        for robot in robots
    ]
    longest = max(math.hypot(*step) for step in steps)
    scale = STRIDE * max(longest / STRIDE, 1.0)
    choices = [_two_ways(dx, dy, scale, float(robot[2])) for (dx, dy), robot in zip(steps, robots, strict=True)]
    pairs = [(one, other) for one in choices[0] for other in choices[1]]
    best = min(pairs, key=lambda pair: abs((pair[0][1] + pair[1][1]) / 2 - twist.turn))
    return best[0][0], best[1][0]


def _two_ways(dx: float, dy: float, scale: float, angle: float) -> list[tuple[DriveCommand, float]]:
    """The same step driven forward and backward, each with the turn that the world adds to it."""
    distance, heading = math.hypot(dx, dy) / scale, heading_of(dx, dy)
    ways = []
    for command in (DriveCommand(distance, heading), DriveCommand(-distance, wrap(heading + math.pi))):
        error = wrap(command.heading - angle)
        if abs(error) > math.pi / 2:
            error = math.copysign(math.pi, error) - error
        ways.append((command, error / TOGETHER_TURN_DIVISOR))
    return ways
