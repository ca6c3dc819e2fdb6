"""The dense reward of the official code (reward_setting "dense"), with its quirks.

It equals the recorded rewards of the official environment to 1e-9 and exists to compare with them; `world.reward`
has the paper's. The quirks that are kept: the approach term is *subtracted* on the tick of a grab; "in the goal" means
that the centre lies in the drawn region shrunk by the item's circumradius, which is not what the score counts.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec
from movingout.maps.shapes import circumradius
from movingout.world.distance import official_distances
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

STEP_COST = -0.001
ZONE_BONUS = 20.0  # per item entering (+) or leaving (-) a goal zone, to whoever holds it, else to the nearest
SMALL_ENTERS_BONUS = 1.0  # to the other robot
HELP_WEIGHT = 20.0  # per unit nearer to the partner's middle or large item
BIG_HOME_WEIGHT, SMALL_HOME_WEIGHT = 20.0, 1.0  # per unit that a held item comes nearer to a goal
GRAB, GRAB_UNWANTED = 5.0, -10.0  # unwanted: already in a goal, or the partner needs help with another
RELEASE_DELIVERED, RELEASE_OUTSIDE = 10.0, -5.0
FRONT = 0.05  # approach is measured from this far ahead of the robot's centre


@dataclass(frozen=True, slots=True)
class _Tick:
    """What the reward needs to know of one tick."""

    before: WorldState
    after: WorldState
    held: list[int]  # by each robot before, -1 none
    holds: list[int]  # by each robot after
    open: npt.NDArray[np.bool_]  # (N,) not delivered before the tick


class OfficialDenseReward:
    """The reward of each tick of one episode, in order: it remembers what was grabbed inside a goal."""

    def __init__(self, map_spec: MapSpec) -> None:
        self.map = map_spec
        self._distances = official_distances(map_spec)
        self._big = [item.size != "small" for item in map_spec.items]
        self._radii = [circumradius(item.shape, item.scale) for item in map_spec.items]
        self._grabbed_inside = [False, False]

    def __call__(self, before: WorldState, after: WorldState) -> Floats:
        """The reward (2,) of the tick between two states."""
        not_delivered = ~delivered_items(self.map, before.item_poses)
        tick = _Tick(before, after, before.held.tolist(), after.held.tolist(), not_delivered)
        reward = np.array([STEP_COST + self._own(robot, tick) for robot in (0, 1)])
        self._add_zone_bonus(reward, tick)
        return reward

    def _own(self, robot: int, tick: _Tick) -> float:
        """Distances and events of one robot, by what its hand did."""
        held, holds = tick.held[robot], tick.holds[robot]
        if held >= 0 and holds >= 0:
            weight = BIG_HOME_WEIGHT if self._big[holds] else SMALL_HOME_WEIGHT
            return weight * (self._home(tick.before, held) - self._home(tick.after, holds))
        if holds >= 0:
            nearer = self._home(tick.before, holds) - self._home(tick.after, holds)
            return nearer - self._approach(robot, tick) + self._grab(robot, tick)
        if held >= 0:
            return self._seek(robot, tick) + self._release(robot, tick)
        return self._seek(robot, tick)

    def _seek(self, robot: int, tick: _Tick) -> float:
        """Reward of an empty hand: for going to help, else for going to the nearest free item."""
        other = 1 - robot
        partners = tick.holds[other]
        if partners < 0 or not self._big[partners]:
            return self._approach(robot, tick)
        if tick.held[other] >= 0:
            now = self._distances.between(tick.after.robot_poses[robot, :2], tick.after.item_poses[partners, :2])
            then = self._distances.between(tick.before.robot_poses[robot, :2], tick.before.item_poses[partners, :2])
            return HELP_WEIGHT * _nearer(then, now)
        return self._approach(robot, tick) if tick.held[robot] >= 0 else 0.0

    def _approach(self, robot: int, tick: _Tick) -> float:
        """By how much the nearest free item came nearer; the partner's items of both states are not free."""
        taken = (tick.held[1 - robot], tick.holds[1 - robot])
        free = [item for item in np.flatnonzero(tick.open).tolist() if item not in taken]
        now = min((self._reach(tick.after, robot, item) for item in free), default=math.inf)
        then = min((self._reach(tick.before, robot, item) for item in free), default=math.inf)
        return _nearer(then, now)

    def _reach(self, state: WorldState, robot: int, item: int) -> float:
        x, y, angle = state.robot_poses[robot].tolist()
        front = np.array([x - FRONT * math.sin(angle), y + FRONT * math.cos(angle)])
        return self._distances.between(front, state.item_poses[item, :2])

    def _grab(self, robot: int, tick: _Tick) -> float:
        item = tick.holds[robot]
        inside = self._in_zone(tick.after, item)
        self._grabbed_inside[robot] = inside
        return GRAB_UNWANTED if inside or self._partner_has_other_big(robot, item, tick) else GRAB

    def _release(self, robot: int, tick: _Tick) -> float:
        item = tick.held[robot]
        if self._in_zone(tick.after, item):
            return 0.0 if self._grabbed_inside[robot] else RELEASE_DELIVERED
        return 0.0 if self._partner_has_other_big(robot, item, tick) else RELEASE_OUTSIDE

    def _partner_has_other_big(self, robot: int, item: int, tick: _Tick) -> bool:
        other = tick.holds[1 - robot]
        return self._big[item] and other not in (-1, item) and self._big[other]

    def _home(self, state: WorldState, item: int) -> float:
        return self._distances.to_goal(state.item_poses[item, :2])

    def _in_zone(self, state: WorldState, item: int) -> bool:
        x, y, _ = state.item_poses[item].tolist()
        r = self._radii[item]
        return any(
            goal.left + r <= x <= goal.right - r and goal.bottom + r <= y <= goal.top - r for goal in self.map.goals
        )

    def _add_zone_bonus(self, reward: Floats, tick: _Tick) -> None:
        for item, big in enumerate(self._big):
            change = self._in_zone(tick.after, item) - self._in_zone(tick.before, item)
            if change == 0:
                continue
            owner = tick.holds.index(item) if item in tick.holds else _nearest_robot(tick.after, item)
            reward[owner] += change * ZONE_BONUS
            if change > 0 and not big:
                reward[1 - owner] += SMALL_ENTERS_BONUS


def _nearest_robot(state: WorldState, item: int) -> int:
    gaps = state.robot_poses[:, :2] - state.item_poses[item, :2]
    return int(np.argmin(np.hypot(gaps[:, 0], gaps[:, 1])))


def _nearer(then: float, now: float) -> float:
    """The distance gained; 0 where there is no way in either state."""
    return then - now if math.isfinite(then) and math.isfinite(now) else 0.0
