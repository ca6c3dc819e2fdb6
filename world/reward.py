"""The paper's reward for learning (appendix "Dense Reward Setting", its table's rows A to D).

`world.official_reward` has what the official code pays instead; the two differ in more than scale.
Where the table leaves something open: "inside a goal region" is what the score counts as delivered; distances are
those of the 48 x 48 grid; a held item's own distance to the goal counts, not its carrier's; on the tick of a grab or
release only events are paid, because the target changes.
"""

import math

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec
from movingout.maps.shapes import box_sides
from movingout.world.distance import paper_distances
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

GAMMA = 20.0  # per unit of distance gained
HOLD, HOLD_UNWANTED = 0.5, -0.5
RELEASE_INSIDE, RELEASE_OUTSIDE, RELEASE_TO_HELP = 0.5, -0.5, 0.5
STEP_COST = -0.01

Flags = npt.NDArray[np.bool_]


class PaperReward:
    """The reward of a tick from the states around it; `dense=False` leaves out row A, the distances."""

    def __init__(self, map_spec: MapSpec, dense: bool = True) -> None:
        self.map = map_spec
        self.dense = dense
        self._distances = paper_distances(map_spec)
        self._big = [item.size != "small" for item in map_spec.items]

    def __call__(self, before: WorldState, after: WorldState) -> Floats:
        """The reward (2,) of the tick between two states: blue's, red's."""
        home_before = delivered_items(self.map, before.item_poses)
        home_after = delivered_items(self.map, after.item_poses)
        return np.array([self._of(seat, before, after, home_before, home_after) for seat in (0, 1)])

    def _of(self, seat: int, before: WorldState, after: WorldState, home_before: Flags, home_after: Flags) -> float:
        held, holds = int(before.held[seat]), int(after.held[seat])
        partner_held, partner_holds = int(before.held[1 - seat]), int(after.held[1 - seat])
        if held < 0 and holds >= 0:
            unwanted = home_before[holds] or self._is_other_big(partner_held, holds)
            return STEP_COST + (HOLD_UNWANTED if unwanted else HOLD)
        if held >= 0 and holds < 0:
            needed = self._is_other_big(partner_holds, held) and not home_after[partner_holds]
            event = RELEASE_INSIDE if home_after[held] else RELEASE_OUTSIDE
            return STEP_COST + event + (RELEASE_TO_HELP if needed else 0.0)
        if not self.dense:
            return STEP_COST
        if holds >= 0:
            return STEP_COST + GAMMA * _gained(self._home(before, held), self._home(after, holds))
        targets = self._targets((partner_held, partner_holds), home_before | home_after)
        return STEP_COST + GAMMA * _gained(self._reach(before, seat, targets), self._reach(after, seat, targets))

    def _targets(self, partners: tuple[int, int], home: Flags) -> list[int]:
        """What an empty hand should go to: the partner's item if it needs help, else the free items."""
        held, holds = partners
        if held == holds and holds >= 0 and self._big[holds] and not home[holds]:
            return [holds]
        return [item for item in np.flatnonzero(~home).tolist() if item not in partners]

    def _is_other_big(self, partners: int, own: int) -> bool:
        """Whether the partner has a middle or large item that is not the one in the own hand."""
        return partners not in (-1, own) and self._big[partners]

    def _home(self, state: WorldState, item: int) -> float:
        return self._distances.one_to_goal(state.item_poses[item, :2])

    def _reach(self, state: WorldState, seat: int, targets: list[int]) -> float:
        """From the robot's centre to the nearest of the targets' holding points."""
        robot = state.robot_poses[seat, :2]
        points = (point for item in targets for point in self._holding_points(item, state.item_poses[item]))
        return min((self._distances.between(robot, point) for point in points), default=math.inf)

    def _holding_points(self, item: int, pose: Floats) -> Floats:
        """(P, 2) the points to approach: an item's centre, a large rectangle's two short sides.

        The paper pays for the short sides on one map, so that the two grasp the ends and fit through; it names
        Four Corners, whose items are no rectangles, so here it goes by the item.
        """
        spec = self.map.items[item]
        if spec.shape != "rectangle" or spec.size != "large":
            return pose[None, :2]
        half = box_sides(spec.shape, spec.scale)[0] / 2
        axis = half * np.array([math.cos(pose[2]), math.sin(pose[2])])
        return np.stack((pose[:2] + axis, pose[:2] - axis))


def _gained(then: float, now: float) -> float:
    """The distance gained; 0 where there is no way in either state."""
    return then - now if math.isfinite(then) and math.isfinite(now) else 0.0
