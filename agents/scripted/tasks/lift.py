"""Heavy items: grabbing one end, waiting for the partner at the other end, and carrying together."""

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.avoidance import lower_bound, side_costs
from movingout.agents.scripted.carrying import paired_carry
from movingout.agents.scripted.carrying.paired_carry import PairCarryPlan
from movingout.agents.scripted.navigation.free_space import FreeSpace, sample, with_robot
from movingout.agents.scripted.navigation.geometry import heading_of, wrap
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.agents.scripted.navigation.motion_choice import REST, CollisionCost, DriveCommand, no_collision_cost
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation, solve
from movingout.agents.scripted.navigation.walking_route import cost_at, walking_costs
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.tasks.approach import NEARLY, Approach, stance_costs, stance_number
from movingout.agents.scripted.tasks.fetch import evaluate_places
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

GOOD_ENOUGH = 80.0  # quarter ticks above the lower bound at which a plan is accepted
DISTINCT_ANGLE = 0.7  # rad by which distinct grasps differ
LEAST_DISTANCE, PREFERRED_DISTANCE = 0.255, 0.33  # units between the robots' centres: required, and preferred
RELEASE_AFTER = 60  # ticks without progress after which both release the item, to grasp it differently
RELEASE_AT_HOME_AFTER = 8  # ticks to hold an item in its goal after the partner has released it
COMFORTABLE_ROOM, CRAMPED = 0.04, 1000.0  # units around a stance; quarter ticks per missing unit
_NEAREST_DECAY = 0.03  # units per tick: a partner that went away counts as coming when it turns back
_CHECKED_PAIRS = 12  # grasp pairs that are checked for whether the first robot blocks the second
NOT_OPPOSITE_COST = 12.0  # quarter ticks per radian by which two grasps are not opposite


class GraspPair(NamedTuple):
    """Stances of both robots at an item: poses (2, 3) in seat order, and the cost of reaching them."""

    score: float
    robots: Floats


def grasp_pairs(now: Perception, item: int, mine: list[float], theirs: list[float]) -> list[GraspPair]:
    """Pairs of stances, quickest to reach first. Both robots compute the same order."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    blue_costs, red_costs = (mine, theirs) if now.seat == 0 else (theirs, mine)
    options = []
    for blue, red, sideways, tightness in _pairs(poses.tobytes()):
        slower, quicker = sorted((blue_costs[blue], red_costs[red]))[::-1]
        if slower < UNREACHED:
            options.append((round(slower + 0.2 * quicker + sideways + tightness), blue, red))
    return [GraspPair(float(score), poses[[blue, red]]) for score, blue, red in sorted(options)]


@lru_cache(maxsize=64)
def _pairs(stances_beside: bytes) -> list[tuple[int, int, float, float]]:
    """Stances (n, 3) of blue and red that can be taken at once: both numbers, and two costs of the pair."""
    poses = np.frombuffer(stances_beside).reshape(-1, 3)
    pairs = []
    for blue, red in itertools.product(range(len(poses)), repeat=2):
        apart = abs(wrap(float(poses[blue, 2] - poses[red, 2])))
        gap = math.dist(poses[blue, :2], poses[red, :2])
        if gap > LEAST_DISTANCE:
            pairs.append((blue, red, NOT_OPPOSITE_COST * (math.pi - apart), _tightness(gap)))
    return pairs


def distinct_grasps(options: list[GraspPair], most: int = 6) -> list[GraspPair]:
    """The first option, and the following ones that differ from all chosen before in at least one stance."""
    chosen: list[GraspPair] = []
    for option in options:
        turns = (np.abs(_wrapped(option.robots[:, 2] - other.robots[:, 2])).max() for other in chosen)
        if all(turn > DISTINCT_ANGLE for turn in turns):
            chosen.append(option)
        if len(chosen) == most:
            break
    return chosen


def _wrapped(angles: Floats) -> Floats:
    return np.asarray((angles + math.pi) % (2 * math.pi) - math.pi)


def _tightness(gap: float) -> float:
    """The cost of two stances so near to each other that one robot may block the other."""
    return max(PREFERRED_DISTANCE - gap, 0.0) * 1000.0


def tight_stance_costs(now: Perception, space: FreeSpace, item: int) -> Floats:
    """(32,) the cost of stances with so little room that imprecise steering fails; `space` is without the item."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    room = sample(space.clearance, poses[:, 0], poses[:, 1]) - ROBOT_RADIUS
    return CRAMPED * np.maximum(COMFORTABLE_ROOM - room, 0.0)


def grasps_beside_partner(now: Perception, item: int, mine: list[float]) -> list[GraspPair]:
    """Stances that go with the partner's grasp, opposite and near ones first."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    centre = now.item_pose(item)
    theirs = heading_of(float(centre[0] - now.partner[0]), float(centre[1] - now.partner[1]))
    options = []
    for number, pose in enumerate(poses):
        apart = abs(wrap(float(pose[2]) - theirs))
        gap = math.dist(pose[:2], now.partner[:2])
        if mine[number] < UNREACHED and gap > LEAST_DISTANCE:
            robots = np.stack([pose, now.partner] if now.seat == 0 else [now.partner, pose])
            score = mine[number] + 2 * NOT_OPPOSITE_COST * (math.pi - apart) + _tightness(gap)
            options.append((score, number, robots))
    return [GraspPair(score, robots) for score, _, robots in sorted(options, key=lambda option: option[:2])]


class Lift:
    """Grabbing one end of a heavy item, waiting for the partner at the other end, and carrying it together."""

    def __init__(
        self,
        now: Perception,
        item: int,
        patience: int,
        failed_stances: frozenset[int],
        yields: bool = False,
        side: float = 0.0,
    ) -> None:
        """`patience`: ticks to wait for the partner. `failed_stances`: not to be used again. `side`: see `Style`."""
        self.item = item
        self.infeasible = False
        self.waited_in_vain = False
        self.given_up: float | None = None  # the heading with which it could not be delivered
        self._failed_stances = failed_stances
        self._patience = patience
        self._yields = yields
        self._side = side
        self._waited = 0
        self._nearest = math.inf
        floor = now.space(also=(item,))
        self._space = with_robot(floor, now.partner) if now.partner_item == item else floor
        self._bare = now.space((item,))
        self._partner_grasp = now.partner.copy() if now.partner_item == item else None
        self._approach: Approach | None = None
        self._decided = False
        self._grasps: SlicedComputation[GraspPair | None] = SlicedComputation(self._compute_grasps(now))
        self._plan: SlicedComputation[PairCarryPlan] | None = None

    @property
    def stance(self) -> int:
        """The chosen stance, -1 while undecided."""
        return stance_number(self._approach.target) if self._approach and self._decided else -1

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends when the item is delivered, cannot be carried, or the partner does not come."""
        if now.own_item == self.item and now.partner_item == self.item:
            return self._carry(now, slices)
        self._plan = None
        if now.own_item == self.item:
            return self._wait(now)
        if self.infeasible or (now.delivered[self.item] and now.partner_item != self.item) or self._outdated(now):
            return None
        return self._go(now, collision_cost, slices)

    def _outdated(self, now: Perception) -> bool:
        """Whether free space or the partner's grasp has changed since the own stance was chosen."""
        if now.space((self.item,)) is not self._bare:
            return True
        if now.partner_item != self.item:
            return False
        return self._partner_grasp is None or bool(np.hypot(*(now.partner - self._partner_grasp)[:2]) > NEARLY)

    def _go(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        if not self._decided:
            self._grasps.advance(slices)
            if self._grasps.done:
                if self._grasps.result is None:
                    self.infeasible = True
                    return None
                self._decided = True
                self._aim(self._grasps.result, now)
        if self._approach is None:
            return REST
        if not self._decided and self._approach.route.cost(float(now.pose[0]), float(now.pose[1])) < 12:
            return REST
        return self._approach.step(now, collision_cost if now.partner_item != self.item else no_collision_cost)

    def _aim(self, grasps: GraspPair, now: Perception) -> None:
        """Walk to the own stance of a pair."""
        self._partner_grasp = grasps.robots[1 - now.seat]
        target = grasps.robots[now.seat]
        if self._approach is None or (self._approach.target != target).any():
            self._approach = Approach(self._space, self.item, target)

    def _wait(self, now: Perception) -> DriveCommand:
        """Keep holding; the time counts only while the partner does not come nearer."""
        gap = float(np.hypot(*(now.partner - now.item_pose(self.item))[:2]))
        self._waited += 1
        if gap < self._nearest - 0.02:
            self._waited = max(self._waited - 4, 0)
        self._nearest = min(gap, self._nearest + _NEAREST_DECAY)
        outbid = self._yields and now.partner_item >= 0 and now.is_heavy(now.partner_item)
        home = bool(now.delivered[self.item])  # the partner released it there, so it is probably good enough
        patience = min(self._patience, RELEASE_AT_HOME_AFTER) if home else self._patience
        if self._waited > patience or outbid:
            self.infeasible, self.waited_in_vain = True, not (outbid or home)
            return DriveCommand(0.0, 0.0, grasp=True)
        return REST

    def _carry(self, now: Perception, slices: int) -> DriveCommand:
        self._waited, self._nearest = 0, math.inf
        if self._plan is None:
            self._plan = SlicedComputation(self._compute_plan(now))
        self._plan.advance(slices)
        if not self._plan.done:
            return REST
        if self._plan.result.idle_ticks > RELEASE_AFTER and not now.delivered[self.item]:
            self.given_up = float(now.pose[2])
            return DriveCommand(0.0, 0.0, grasp=True)
        return self._plan.result.drive(now.item_pose(self.item), now.robots)[now.seat]

    def _compute_plan(self, now: Perception) -> Computation[PairCarryPlan]:
        places = yield from evaluate_places(now, self.item)
        for margin in (paired_carry.EASY, paired_carry.TIGHT):
            carry_plan = PairCarryPlan(
                now.space(), now.item(self.item), now.item_pose(self.item), now.robots, places, margin
            )
            yield
            yield from solve(carry_plan.cost_to_go, lambda: carry_plan.cost(now.item_pose(self.item)))  # noqa: B023
            if carry_plan.cost(now.item_pose(self.item)) < UNREACHED:
                break
        return carry_plan

    def _passable(self, now: Perception, options: list[GraspPair]) -> list[GraspPair]:
        """The options with which the first robot does not block the second; all if there are none."""
        free = [grasps for grasps in options[:_CHECKED_PAIRS] if self._leaves_room(now, grasps)]
        return [*free, *options[_CHECKED_PAIRS:]] or options

    def _leaves_room(self, now: Perception, grasps: GraspPair) -> bool:
        """Whether the slower robot can still reach its stance when the quicker one is at its own."""
        gaps = [self._walk(self._space, now, seat, grasps) for seat in (0, 1)]
        first = 0 if gaps[0] <= gaps[1] else 1
        return self._walk(with_robot(self._space, grasps.robots[first]), now, 1 - first, grasps) < UNREACHED

    def _walk(self, space: FreeSpace, now: Perception, seat: int, grasps: GraspPair) -> float:
        """Walking cost [quarter ticks] of a seat to its stance."""
        robot, stance = now.robots[seat], grasps.robots[seat]
        return cost_at(walking_costs(space, [(float(robot[0]), float(robot[1]))]), float(stance[0]), float(stance[1]))

    def _compute_grasps(self, now: Perception) -> Computation[GraspPair | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        walks = stance_costs(now, self._space, now.pose, self.item, self._failed_stances)
        narrow = tight_stance_costs(now, self._bare, self.item)
        mine = (np.array(walks) + side_costs(now, self.item, self._side) + narrow).tolist()
        yield
        if now.partner_item == self.item:
            options = grasps_beside_partner(now, self.item, mine)
        else:
            theirs = (np.array(stance_costs(now, self._space, now.partner, self.item)) + narrow).tolist()
            yield
            options = grasp_pairs(now, self.item, mine, theirs)
        if not options:
            return None
        options = options if now.partner_item == self.item else self._passable(now, options)
        self._aim(options[0], now)
        least = lower_bound(now, self.item)
        yield
        best: tuple[float, GraspPair] | None = None
        varied = distinct_grasps(options)
        places = yield from evaluate_places(now, self.item)
        for margin, tried in ((paired_carry.EASY, varied), (paired_carry.TIGHT, varied[:2])):
            for grasps in tried:
                carry_plan = PairCarryPlan(self._bare, spec, item_pose, grasps.robots, places, margin)
                yield
                yield from solve(carry_plan.cost_to_go, lambda: carry_plan.cost(item_pose))  # noqa: B023
                cost = carry_plan.cost(item_pose)
                if cost < UNREACHED and (best is None or cost + grasps.score < best[0]):
                    best = (cost + grasps.score, grasps)
                if cost < least + GOOD_ENOUGH:
                    return grasps
            if best is not None:
                return best[1]
        return None
