"""Carrying alone: the robot and the item ahead of it are one rigid body that drives like a robot."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from movingout.agents.scripted.navigation.cost_search import CostToGo, Search, shared_search
from movingout.agents.scripted.navigation.free_space import FreeSpace, overlap_cost
from movingout.agents.scripted.navigation.geometry import Disc, covering_discs, forward, half_extents, wrap
from movingout.agents.scripted.navigation.motion_choice import (
    HORIZON,
    STRIDE,
    CollisionCost,
    DriveCommand,
    best_move,
    drive,
    short_moves,
    turn_to,
)
from movingout.agents.scripted.navigation.pose_grid import (
    SOLO_MOTION,
    UNIT_PER_TICK,
    costs_at_poses,
    grid_pose,
    nearest_cost,
    next_pose,
)
from movingout.agents.scripted.placement.goal_places import Places, place_costs
from movingout.agents.scripted.placement.goal_storage import EXACT_CROWDING, goal_storage
from movingout.agents.scripted.placement.handover_lanes import HandoverLane, handover_costs
from movingout.maps import ItemSpec, MapSpec
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats

_SETTLED = 2.0  # quarter ticks: a place this much worse than the best one still to be had is good enough
SETTLE_AFTER = 6  # ticks without getting nearer after which a place that is nearly the best is good enough
_NEAR_BEST = 25.0  # quarter ticks: that near
_ACCEPT_ANY_AFTER = 25  # ticks without getting nearer after which any place in a goal region is good enough
_FOLLOW_PLAN_AFTER = 3  # ticks without getting nearer after which the plan is followed step by step
_ADJUSTMENTS = 8  # ticks at most for that, and for putting an item down exactly
_ANGLE_TOLERANCE, _DISTANCE_TOLERANCE = 0.03, 0.006  # rad and units that are exact enough
_ROUGH_ANGLE_TOLERANCE = 0.1  # rad that are exact enough on the way: a hand that is not steady never gets nearer
_TICKS = UNIT_PER_TICK * np.arange(1, HORIZON + 1)


def margins(map_spec: MapSpec) -> tuple[float, float]:
    """Units to keep from everything: where there is room, and where there is none."""
    crowding = goal_storage(map_spec).crowding
    return (0.02 if not crowding else 0.01 if crowding < EXACT_CROWDING else 0.005), 0.003


Offset = tuple[float, float, float]  # an item's pose in the robot's frame


class DrivePlan:
    """A robot, with or without an item ahead, on its way over a terrain."""

    def __init__(self, space: FreeSpace, discs: Sequence[Disc], search: Search) -> None:
        self.space = space
        self.discs = discs
        self.cost_to_go = CostToGo(search)

    def cost(self, pose: Floats) -> float:
        """Quarter ticks from a robot pose (3,)."""
        return float(self.costs_at(pose[None])[0])

    def costs_at(self, poses: Floats) -> Floats:
        """(M,) likewise from robot poses (M, 3)."""
        return costs_at_poses(self.cost_to_go.cost, SOLO_MOTION, poses)

    def costs(self, moves: Floats) -> Floats:
        """(K,) for short moves (K, HORIZON, 3)."""
        left = self.costs_at(moves.reshape(-1, 3)).reshape(moves.shape[:2])
        through = (left + _TICKS).max(axis=1)  # a way through something is as dear as its worst pose
        pressed = overlap_cost(self.space, self.discs, moves).max(axis=1)
        return np.asarray(0.5 * (left[:, -1] + through) + pressed)

    def look_farther(self, pose: Floats) -> float:
        """The cost from a pose (3,); searches on a little when the robot was pushed out of what is known."""
        cost = self.cost(pose)
        if cost < UNREACHED or self.cost_to_go.done:
            return cost
        self.cost_to_go.search()
        return self.cost(pose)

    def move(self, pose: Floats, collision_cost: CollisionCost) -> DriveCommand:
        """The next command of a robot at a `pose` (3,) from which there is a way."""
        return best_move(pose, lambda moves: self.costs(moves) + collision_cost(moves))[0]


class SoloCarryPlan(DrivePlan):
    """The way of one item to its place in a goal, for a robot that holds it (or will hold it right ahead)."""

    def __init__(
        self,
        space: FreeSpace,
        item: ItemSpec,
        offset: Offset,
        places: Places,
        margin: float,
        handover: HandoverLane | None = None,
    ) -> None:
        """`offset` is the item's pose in the robot's frame; the terrain must not contain the item.

        `look` says what the places in the goal regions are worth. With `meeting` it goes to the
        meeting place instead of a goal region.
        """
        search = _search(space, item, offset, places, margin, handover)
        super().__init__(space, _discs(item, offset), search)
        self.item = item
        self._goals = goal_boxes(space.map)
        self.handover = handover
        self._places = search.starts
        self._progress = StallCounter()
        store = goal_storage(space.map)
        self._must_be_exact = handover is None and len(store.slots) > 0 and store.crowding >= EXACT_CROWDING
        self._aim: tuple[float, float, float] | None = None
        self._adjustments = 0

    def drive(self, pose: Floats, item_pose: Floats, collision_cost: CollisionCost, steady: bool) -> DriveCommand:
        """The next command of a robot at `pose` (3,) that holds the item; lets go where it should lie.

        A `steady` hand can follow the plan step by step and put things down exactly.
        """
        left = self.look_farther(pose)
        there = self.handover is not None or is_delivered(self.item, tuple(item_pose.tolist()), self._goals)
        command, _ = best_move(pose, lambda moves: self.costs(moves) + collision_cost(moves))
        ticks = self._progress.idle_ticks(left) if there or steady else 0
        if there and self._good_enough(pose, left, ticks, command):
            return (self._adjusted(pose) if steady else None) or DriveCommand(0.0, 0.0, grasp=True)
        if (
            steady
            and _FOLLOW_PLAN_AFTER <= ticks < _FOLLOW_PLAN_AFTER + _ADJUSTMENTS
            and left < UNREACHED
            and not collision_cost(short_moves(pose)).any()
        ):
            return self._next_step(pose) or command
        return command

    def _next_step(self, pose: Floats) -> DriveCommand | None:
        """Exactly what the plan says, where there is so little room that moves which look good lead nowhere."""
        return _towards(pose, next_pose(self.cost_to_go.cost, SOLO_MOTION, pose), _ROUGH_ANGLE_TOLERANCE)

    def _adjusted(self, pose: Floats) -> DriveCommand | None:
        """A small move to where exactly the item was to be put down, where that matters; None when it lies well."""
        if self._aim is None and self._must_be_exact:
            self._aim = grid_pose(SOLO_MOTION, pose)
        if self._aim is None or self._adjustments == _ADJUSTMENTS:
            return None
        self._adjustments += 1
        return _towards(pose, self._aim, _ANGLE_TOLERANCE)

    def _good_enough(self, pose: Floats, left: float, ticks: int, command: DriveCommand) -> bool:
        """Whether this is the place: the best one, or one nearly as good where nothing gets on any more."""
        loss = nearest_cost(self._places, SOLO_MOTION, pose) - left
        stays = ticks >= SETTLE_AFTER or command.distance == 0.0
        if self._aim is not None:
            return True
        return loss <= _SETTLED or (stays and loss <= _NEAR_BEST) or ticks >= _ACCEPT_ANY_AFTER


def _towards(pose: Floats, target: tuple[float, float, float], tolerance: float) -> DriveCommand | None:
    """First turn to within `askew` rad, then go ahead or back; None for a robot that can do no more that way."""
    x, y, heading = target
    if abs(wrap(heading - float(pose[2]))) > tolerance:
        return turn_to(heading)
    dx, dy = forward(heading)
    ahead = dx * (x - float(pose[0])) + dy * (y - float(pose[1]))
    return drive(heading, min(max(ahead / STRIDE, -1.0), 1.0)) if abs(ahead) > _DISTANCE_TOLERANCE else None


@lru_cache(maxsize=32)
def _search(
    space: FreeSpace, item: ItemSpec, offset: Offset, places: Places, margin: float, handover: HandoverLane | None
) -> Search:
    x, y, phase = offset
    if handover is None:
        angles = np.arange(SOLO_MOTION.headings) * 2 * np.pi / SOLO_MOTION.headings
        extents = np.array([half_extents(item, float(angle) + phase) for angle in angles])
        starts = place_costs(space, SOLO_MOTION, (x, y), extents, [(0.0, 0.0)], places)
    else:
        starts = handover_costs(handover, SOLO_MOTION, (x, y))
    return shared_search(space, _discs(item, offset), SOLO_MOTION, margin, starts)


def _discs(item: ItemSpec, offset: Offset) -> list[Disc]:
    """The robot and the item ahead."""
    return [(0.0, 0.0, ROBOT_RADIUS), *carried_discs(item, offset)]


class StallCounter:
    """Since when a cost-to-go does not fall any more."""

    def __init__(self) -> None:
        self._least = math.inf
        self.ticks = 0  # without getting nearer

    def idle_ticks(self, cost: float) -> int:
        """Note the cost of this tick; how many ticks have brought nothing."""
        if cost < self._least - 1.0:
            self._least, self.ticks = cost, 0
        else:
            self.ticks += 1
        return self.ticks


def carried_discs(item: ItemSpec, offset: Offset) -> list[Disc]:
    """The discs of an item whose pose in the robot's frame is `offset`."""
    x, y, phase = offset
    cos, sin = math.cos(phase), math.sin(phase)
    return [(x + dx * cos - dy * sin, y + dx * sin + dy * cos, radius) for dx, dy, radius in covering_discs(item)]
