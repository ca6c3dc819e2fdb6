"""The dense reward of the official code (reward_setting "dense"), with its quirks.

It equals the recorded rewards of the official environment to 1e-9 and exists to compare with them; `world.reward`
has the paper's. The quirks that are kept: the approach term is *subtracted* on the tick of a grab; "in the goal" means
that the centre lies in the drawn region shrunk by the item's circumradius, which is not what the score counts.
"""

import math

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.shapes import circumradius
from movingout.world.distance import Place, gained, official_distances
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats, WorldState

STEP_COST = -0.001
ZONE_BONUS = 20.0  # per item entering (+) or leaving (-) a goal zone, to whoever holds it, else to the nearest
SMALL_ENTERS_BONUS = 1.0  # to the other robot
HELP_WEIGHT = 20.0  # per unit nearer to the partner's middle or large item
BIG_HOME_WEIGHT, SMALL_HOME_WEIGHT = 20.0, 1.0  # per unit that a held item comes nearer to a goal
GRAB, GRAB_UNWANTED = 5.0, -10.0  # unwanted: already in a goal, or the partner needs help with another
RELEASE_DELIVERED, RELEASE_OUTSIDE = 10.0, -5.0
FRONT = 0.05  # approach is measured from this far ahead of the robot's centre


class _Rules:
    """What the reward asks about a map: its distances, its items and its goal regions."""

    def __init__(self, map_spec: MapSpec) -> None:
        self.distances = official_distances(map_spec)
        self.big = [item.size != "small" for item in map_spec.items]
        self._items = map_spec.items
        self._goals = goal_boxes(map_spec)
        self._zones = [_shrunk(map_spec, circumradius(item.shape, item.scale)) for item in map_spec.items]

    def is_delivered(self, item: int, pose: list[float]) -> bool:
        return is_delivered(self._items[item], tuple(pose), self._goals)

    def is_in_zone(self, item: int, pose: list[float]) -> bool:
        """Whether an item's centre lies in a drawn goal region, shrunk by its circumradius."""
        x, y, _ = pose
        return any(left <= x <= right and bottom <= y <= top for left, bottom, right, top in self._zones[item])


class _OfficialMoment:
    """What the reward needs to know of one state.

    Items that lie where they lay in the state `last` keep what was worked out then.
    """

    def __init__(self, rules: _Rules, state: WorldState, last: "_OfficialMoment | None") -> None:
        self.state = state
        self.held: list[int] = state.held.tolist()  # by each robot, -1 none
        self.poses: list[list[float]] = state.item_poses.tolist()
        self.robots: list[list[float]] = state.robot_poses.tolist()
        self._rules, self._place = rules, rules.distances.place
        self._nearest: dict[tuple[int, ...], float] = {}
        self._fronts = [
            self._place(x - FRONT * math.sin(angle), y + FRONT * math.cos(angle)) for x, y, angle in self.robots
        ]
        changed = list(range(len(self.poses)))
        if last is None:
            self.delivered, self.in_zone = [False] * len(self.poses), [False] * len(self.poses)
            self._places: list[Place] = [(0, 0)] * len(self.poses)
        else:
            self.delivered, self.in_zone, self._places = last.delivered.copy(), last.in_zone.copy(), last._places.copy()
            changed = [item for item in changed if self.poses[item] != last.poses[item]]
        for item in changed:
            pose = self.poses[item]
            self.delivered[item], self.in_zone[item] = rules.is_delivered(item, pose), rules.is_in_zone(item, pose)
            self._places[item] = self._place(pose[0], pose[1])

    def home(self, item: int) -> float:
        """From an item's centre to the nearest drawn goal region."""
        return self._rules.distances.to_goal(self.state.item_poses[item, :2])

    def from_centre(self, robot: int, item: int) -> float:
        """From a robot's centre to an item's."""
        x, y, _ = self.robots[robot]
        return self._rules.distances.between(self._place(x, y), self._places[item])

    def reach(self, robot: int, items: list[int]) -> float:
        """From a little ahead of a robot to the nearest of the items' centres; `inf` without any."""
        key = (robot, *items)  # asked again as the state before the next tick
        found = self._nearest.get(key)
        if found is None:
            front, places, between = self._fronts[robot], self._places, self._rules.distances.between
            found = min([between(front, places[item]) for item in items], default=math.inf)
            self._nearest[key] = found
        return found


class OfficialDenseReward:
    """The reward of each tick of one episode, in order: it remembers what was grabbed inside a goal."""

    def __init__(self, map_spec: MapSpec) -> None:
        self.map = map_spec
        self._rules = _Rules(map_spec)
        self._big = self._rules.big
        self._grabbed_inside = [False, False]
        self._last: _OfficialMoment | None = None

    def __call__(self, before: WorldState, after: WorldState) -> Floats:
        """The reward (2,) of the tick between two states."""
        then = self._last
        if then is None or then.state is not before:
            then = _OfficialMoment(self._rules, before, None)
        now = then if after is before else _OfficialMoment(self._rules, after, then)
        self._last = now
        rewards = [STEP_COST + self._own(robot, then, now) for robot in (0, 1)]
        self._add_zone_bonus(rewards, then, now)
        return np.array(rewards)

    def _own(self, robot: int, then: _OfficialMoment, now: _OfficialMoment) -> float:
        """Distances and events of one robot, by what its hand did."""
        held, holds = then.held[robot], now.held[robot]
        if held >= 0 and holds >= 0:
            weight = BIG_HOME_WEIGHT if self._big[holds] else SMALL_HOME_WEIGHT
            return weight * (then.home(held) - now.home(holds))
        if holds >= 0:
            nearer = then.home(holds) - now.home(holds)
            return nearer - self._approach(robot, then, now) + self._grab(robot, now)
        if held >= 0:
            return self._seek(robot, then, now) + self._release(robot, then, now)
        return self._seek(robot, then, now)

    def _seek(self, robot: int, then: _OfficialMoment, now: _OfficialMoment) -> float:
        """Reward of an empty hand: for going to help, else for going to the nearest free item."""
        other = 1 - robot
        partners = now.held[other]
        if partners < 0 or not self._big[partners]:
            return self._approach(robot, then, now)
        if then.held[other] >= 0:
            return HELP_WEIGHT * gained(then.from_centre(robot, partners), now.from_centre(robot, partners))
        return self._approach(robot, then, now) if then.held[robot] >= 0 else 0.0

    def _approach(self, robot: int, then: _OfficialMoment, now: _OfficialMoment) -> float:
        """By how much the nearest free item came nearer; the partner's items of both states are not free."""
        other = 1 - robot
        held, holds = then.held[other], now.held[other]
        free = [item for item, there in enumerate(then.delivered) if not there and item != held and item != holds]
        return gained(then.reach(robot, free), now.reach(robot, free))

    def _grab(self, robot: int, now: _OfficialMoment) -> float:
        item = now.held[robot]
        inside = now.in_zone[item]
        self._grabbed_inside[robot] = inside
        return GRAB_UNWANTED if inside or self._partner_has_other_big(robot, item, now) else GRAB

    def _release(self, robot: int, then: _OfficialMoment, now: _OfficialMoment) -> float:
        item = then.held[robot]
        if now.in_zone[item]:
            return 0.0 if self._grabbed_inside[robot] else RELEASE_DELIVERED
        return 0.0 if self._partner_has_other_big(robot, item, now) else RELEASE_OUTSIDE

    def _partner_has_other_big(self, robot: int, item: int, now: _OfficialMoment) -> bool:
        other = now.held[1 - robot]
        return self._big[item] and other not in (-1, item) and self._big[other]

    def _add_zone_bonus(self, rewards: list[float], then: _OfficialMoment, now: _OfficialMoment) -> None:
        if then.in_zone == now.in_zone:
            return
        for item, big in enumerate(self._big):
            change = now.in_zone[item] - then.in_zone[item]
            if change == 0:
                continue
            owner = now.held.index(item) if item in now.held else _nearest_robot(now, item)
            rewards[owner] += change * ZONE_BONUS
            if change > 0 and not big:
                rewards[1 - owner] += SMALL_ENTERS_BONUS


def _shrunk(map_spec: MapSpec, by: float) -> list[tuple[float, float, float, float]]:
    """Left, bottom, right, top of the drawn goal regions without a margin of this width."""
    return [(goal.left + by, goal.bottom + by, goal.right - by, goal.top - by) for goal in map_spec.goals]


def _nearest_robot(now: _OfficialMoment, item: int) -> int:
    x, y, _ = now.poses[item]
    gaps = [math.hypot(robot[0] - x, robot[1] - y) for robot in now.robots]
    return gaps.index(min(gaps))
