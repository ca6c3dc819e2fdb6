"""Carrying alone: the robot and the item ahead of it form one rigid body that drives like a robot."""

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

_SETTLED = 2.0  # quarter ticks by which a place may be worse than the best reachable one
SETTLE_AFTER = 6  # ticks without progress after which a nearly best place is accepted
_NEAR_BEST = 25.0  # quarter ticks from the best place
_ACCEPT_ANY_AFTER = 25  # ticks without progress after which any place in a goal is accepted
_FOLLOW_PLAN_AFTER = 3  # ticks without progress after which the plan is followed step by step
_ADJUSTMENTS = 8  # ticks at most for that, and for exact placement
_ANGLE_TOLERANCE, _DISTANCE_TOLERANCE = 0.03, 0.006  # rad and units of exact placement
_ROUGH_ANGLE_TOLERANCE = 0.1  # rad on the way; unsteady steering would never reach a smaller one
_TICKS = UNIT_PER_TICK * np.arange(1, HORIZON + 1)


def margins(map_spec: MapSpec) -> tuple[float, float]:
    """Margins [u] to keep from obstacles: with enough room, and with little."""
    crowding = goal_storage(map_spec).crowding
    return (0.02 if not crowding else 0.01 if crowding < EXACT_CROWDING else 0.005), 0.003


Offset = tuple[float, float, float]  # an item's pose in the robot's frame


class DrivePlan:
    """A plan to drive a robot, with or without an item ahead, to a goal pose."""

    def __init__(self, space: FreeSpace, discs: Sequence[Disc], search: Search) -> None:
        self.space = space
        self.discs = discs
        self.cost_to_go = CostToGo(search)

    def cost(self, pose: Floats) -> float:
        """Quarter ticks from a robot pose (3,)."""
        return float(self.costs_at(pose[None])[0])

    def costs_at(self, poses: Floats) -> Floats:
        """(M,) quarter ticks from robot poses (M, 3)."""
        return costs_at_poses(self.cost_to_go.cost, SOLO_MOTION, poses)

    def costs(self, moves: Floats) -> Floats:
        """(K,) costs of short moves (K, HORIZON, 3)."""
        left = self.costs_at(moves.reshape(-1, 3)).reshape(moves.shape[:2])
        through = (left + _TICKS).max(axis=1)  # a move through an obstacle costs as much as its worst pose
        pressed = overlap_cost(self.space, self.discs, moves).max(axis=1)
        return np.asarray(0.5 * (left[:, -1] + through) + pressed)

    def look_farther(self, pose: Floats) -> float:
        """The cost from a pose (3,); extends the search when the robot was pushed beyond what is known."""
        cost = self.cost(pose)
        if cost < UNREACHED or self.cost_to_go.done:
            return cost
        self.cost_to_go.search()
        return self.cost(pose)

    def move(self, pose: Floats, collision_cost: CollisionCost) -> DriveCommand:
        """The next command of a robot at a `pose` (3,) with a known cost."""
        return best_move(pose, lambda moves: self.costs(moves) + collision_cost(moves))[0]


class SoloCarryPlan(DrivePlan):
    """The plan for an item that a robot holds, or will hold ahead of it."""

    def __init__(
        self,
        space: FreeSpace,
        item: ItemSpec,
        offset: Offset,
        places: Places,
        margin: float,
        handover: HandoverLane | None = None,
    ) -> None:
        """`offset`: the item's pose in the robot's frame. `space` is without the item.

        `places`: the costs of places in the goals. With `handover` the destination is the handover point
        instead of a goal.
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

    def drive(
        self, pose: Floats, item_pose: Floats, collision_cost: CollisionCost, steady: bool, only_there: bool = False
    ) -> DriveCommand:
        """The next command of a robot at `pose` (3,) that holds the item; releases it at its place.

        With `steady` steering the plan can be followed step by step and the item placed exactly. `only_there`: never
        hand an item over before the handover point.
        """
        left = self.look_farther(pose)
        there = self._is_at_handover(item_pose, only_there) or is_delivered(
            self.item, tuple(item_pose.tolist()), self._goals
        )
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

    def _is_at_handover(self, item_pose: Floats, only_there: bool) -> bool:
        return self.handover is not None and (not only_there or self.handover.is_handed_over(item_pose))

    def _next_step(self, pose: Floats) -> DriveCommand | None:
        """The exact next step of the plan, for where there is too little room for the short moves."""
        return _towards(pose, next_pose(self.cost_to_go.cost, SOLO_MOTION, pose), _ROUGH_ANGLE_TOLERANCE)

    def _adjusted(self, pose: Floats) -> DriveCommand | None:
        """A small move to the exact place, where that matters; None when the item is there."""
        if self._aim is None and self._must_be_exact:
            self._aim = grid_pose(SOLO_MOTION, pose)
        if self._aim is None or self._adjustments == _ADJUSTMENTS:
            return None
        self._adjustments += 1
        return _towards(pose, self._aim, _ANGLE_TOLERANCE)

    def _good_enough(self, pose: Floats, left: float, ticks: int, command: DriveCommand) -> bool:
        """Whether to release the item here: at the best place, or at a nearly best one after a stall."""
        loss = nearest_cost(self._places, SOLO_MOTION, pose) - left
        stays = ticks >= SETTLE_AFTER or command.distance == 0.0
        if self._aim is not None:
            return True
        return loss <= _SETTLED or (stays and loss <= _NEAR_BEST) or ticks >= _ACCEPT_ANY_AFTER


def _towards(pose: Floats, target: tuple[float, float, float], tolerance: float) -> DriveCommand | None:
    """Turn to within `tolerance` rad, then drive forward or backward; None when that brings no improvement."""
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
    """The discs of the robot and of the item ahead."""
    return [(0.0, 0.0, ROBOT_RADIUS), *carried_discs(item, offset)]


class StallCounter:
    """Counts the ticks without progress, that is, without a lower cost-to-go."""

    def __init__(self) -> None:
        self._least = math.inf
        self.ticks = 0  # without progress

    def idle_ticks(self, cost: float) -> int:
        """Note the cost of this tick; returns the ticks without progress."""
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
