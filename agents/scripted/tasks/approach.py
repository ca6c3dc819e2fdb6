"""Walking to a stance beside an item and grabbing it."""

import math

from movingout.agents.scripted.navigation.free_space import FreeSpace, sample
from movingout.agents.scripted.navigation.geometry import heading_of, wrap
from movingout.agents.scripted.navigation.grasp_stance import HEADINGS, reaching_heading, stances, within_reach
from movingout.agents.scripted.navigation.motion_choice import CollisionCost, DriveCommand, best_move, drive, turn_to
from movingout.agents.scripted.navigation.walking_route import cost_at, route_to, walking_costs
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED, Mask
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

NEAR = 0.05  # units from its stance at which the robot turns to the item
WAITED_FOR = 0.15  # units from its stance within which any grasp will do when the partner holds the other end
APART = 0.3  # units between the robots' centres at which both can turn what they hold
NEARLY = 0.09  # units from its stance within which the grasp counts as the planned one


def stance_costs(
    now: Perception, space: FreeSpace, position: Floats, item: int, failed_stances: frozenset[int] = frozenset()
) -> list[float]:
    """Walking cost [quarter ticks] to each of the 32 stances; UNREACHED where a robot has no room or cannot grab.

    `failed_stances` are those from which a grab has failed, contrary to prediction.
    """
    lengths = walking_costs(space, [(float(position[0]), float(position[1]))])
    poses, useful = stances(now.item(item), now.item_pose(item))
    room = sample(space.clearance, poses[:, 0], poses[:, 1]) >= ROBOT_RADIUS - 0.006
    return [
        cost_at(lengths, x, y) if fits and number not in failed_stances else float(UNREACHED)
        for number, ((x, y, _), fits) in enumerate(zip(poses.tolist(), room & useful, strict=True))
    ]


class Approach:
    """Walking to a stance beside an item and grabbing it."""

    def __init__(self, space: FreeSpace, item: int, target: Floats, avoided: Mask | None = None) -> None:
        self.item = item
        self.target = target
        self.space = space
        self.route = route_to(space, [(float(target[0]), float(target[1]))], avoided)

    def step(self, now: Perception, collision_cost: CollisionCost) -> DriveCommand:
        """The next command, with a grab as soon as the item is within reach."""
        pose, goal = now.pose, now.item_pose(self.item)
        to_item = heading_of(float(goal[0] - pose[0]), float(goal[1] - pose[1]))
        off = wrap(to_item - float(pose[2]))
        gap = math.hypot(float(pose[0] - self.target[0]), float(pose[1] - self.target[1]))
        if self._well_placed(now, gap) and within_reach(now.item(self.item), goal, pose):
            return DriveCommand(0.3, float(pose[2]), grasp=True)
        if self._is_waited_for(now, gap):
            turned = reaching_heading(now.item(self.item), goal, pose)
            if turned is not None:
                return turn_to(turned)
        if gap < NEAR or self.route.cost(float(pose[0]), float(pose[1])) <= 2.0:
            gently = 0.35 if now.is_heavy(self.item) else 1.0  # with a hard push the robot would slide along the item
            return drive(to_item, gently) if abs(off) < 0.3 else turn_to(to_item)
        command, _ = best_move(pose, lambda moves: self.route.costs(moves) + collision_cost(moves))
        return command

    def _well_placed(self, now: Perception, gap: float) -> bool:
        """A small item may be grabbed from any side; for a heavy one the stance was planned."""
        if self._is_waited_for(now, gap):
            return True
        return not now.is_heavy(self.item) or (gap < NEARLY and abs(wrap(float(now.pose[2] - self.target[2]))) < 0.35)

    def _is_waited_for(self, now: Perception, gap: float) -> bool:
        """Whether the partner waits at the other end, so that any grasp near the planned one will do."""
        if now.intent is None or now.partner_item != self.item or gap > WAITED_FOR:
            return False
        return math.dist(now.pose[:2].tolist(), now.partner[:2].tolist()) > APART


def stance_number(target: Floats) -> int:
    """The number of the stance at a pose, 0 to 31."""
    return round(float(target[2]) / (2 * math.pi / len(HEADINGS))) % len(HEADINGS)
