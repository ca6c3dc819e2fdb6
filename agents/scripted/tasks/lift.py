"""Heavy items: grabbing one end, waiting for the partner at the other end, and carrying together."""

import math

import numpy as np

from movingout.agents.scripted.avoidance import lower_bound, side_costs
from movingout.agents.scripted.carrying import paired_carry
from movingout.agents.scripted.carrying.paired_carry import PairCarryPlan
from movingout.agents.scripted.navigation.free_space import FreeSpace, with_robot
from movingout.agents.scripted.navigation.motion_choice import REST, CollisionCost, DriveCommand, no_collision_cost
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation, solve
from movingout.agents.scripted.navigation.walking_route import cost_at, walking_costs
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.tasks.approach import NEARLY, Approach, stance_costs, stance_number
from movingout.agents.scripted.tasks.fetch import evaluate_places
from movingout.agents.scripted.tasks.grasp_pairs import (
    GraspPair,
    distinct_grasps,
    grasp_pairs,
    grasps_beside_partner,
    tight_stance_costs,
)
from movingout.agents.scripted.tasks.joint_carry import JointCarry
from movingout.maps.flood_fill import UNREACHED

GOOD_ENOUGH = 80.0  # quarter ticks above the lower bound at which a plan is accepted
RELEASE_AFTER = 60  # ticks without progress after which both release the item, to grasp it differently
RELEASE_AT_HOME_AFTER = 8  # ticks to hold an item in its goal after the partner has released it
WAITS_UNSEEN = 15  # ticks to hold an item to which nobody comes when there is something else to do
YIELDS_AFTER = (9, 5)  # ticks after which blue and red let go for a partner that holds another heavy item
_HURRY = 3  # times the usual planning while the partner holds the other end and waits
_NEAREST_DECAY = 0.03  # units per tick: a partner that went away counts as coming when it turns back
_CHECKED_PAIRS = 12  # grasp pairs that are checked for whether the first robot blocks the second


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
        self.left_early = False  # for something that mattered more
        self.got_stuck = False  # both held it, and it did not get on
        self.given_up: float | None = None  # the heading with which it could not be delivered
        self._failed_stances = failed_stances
        self._patience = patience
        self._yields = yields
        self._side = side
        self._waited = 0
        self._alone = 0  # ticks for which nobody has come
        self._nearest = math.inf
        floor = now.space(also=(item,))
        self._space = with_robot(floor, now.partner) if now.partner_item == item else floor
        self._bare = now.space((item,))
        self._partner_grasp = now.partner.copy() if now.partner_item == item else None
        self._approach: Approach | None = None
        self._decided = False
        self._grasps: SlicedComputation[GraspPair | None] = SlicedComputation(self._compute_grasps(now))
        self._plan: SlicedComputation[PairCarryPlan] | None = None
        self._joint = JointCarry()
        self._planned_goal = -1

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
            awaited = now.intent is not None and now.partner_item == self.item
            self._grasps.advance(_HURRY * slices if awaited else slices)
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
        outbid = self._is_outbid(now)
        home = bool(now.delivered[self.item])  # the partner released it there, so it is probably good enough
        at_home = RELEASE_AT_HOME_AFTER if now.intent is None else 0  # who passes by could push it out again
        patience = min(self._patience, at_home) if home else self._patience
        self._alone = 0 if now.intent is None or now.intent.is_coming(now.state, self.item) else self._alone + 1
        leaves = not home and now.intent is not None and self._alone > WAITS_UNSEEN and self._is_useful_elsewhere(now)
        if self._waited > patience or outbid or leaves:
            self.infeasible, self.waited_in_vain = True, not (outbid or home)
            self.left_early = now.intent is not None and (outbid or leaves)
            return DriveCommand(0.0, 0.0, grasp=True)
        return REST

    def _is_outbid(self, now: Perception) -> bool:
        """Whether to let go because the partner holds another heavy item: red before blue, so that one stays."""
        if now.partner_item < 0 or not now.is_heavy(now.partner_item) or now.delivered[now.partner_item]:
            return False
        held_for = now.tick - now.intent.holds_since if now.intent is not None else 0
        return self._yields or (now.intent is not None and min(held_for, self._waited) >= YIELDS_AFTER[now.seat])

    def _is_useful_elsewhere(self, now: Perception) -> bool:
        """Whether there is something else to do: a small item, or a heavy one to which the partner goes."""
        assert now.intent is not None
        heavy = [item for item in now.waiting if now.is_heavy(item)]
        return len(heavy) < len(now.waiting) or now.intent.meant(now.state, heavy) >= 0

    def _carry(self, now: Perception, slices: int) -> DriveCommand:
        self._waited, self._nearest, self._alone = 0, math.inf, 0
        if self._plan is None or self._joint.goal != self._planned_goal:
            self._planned_goal = self._joint.goal
            self._plan = SlicedComputation(self._compute_plan(now))
        if now.intent is None:
            self._plan.advance(slices)
            return self._planned(now)
        self._plan.advance(_HURRY * slices)
        if now.delivered[self.item] and self._joint.gave_in:
            return DriveCommand(0.0, 0.0, grasp=True)  # it lies well enough, and another pull may spoil it
        if self._joint.is_stuck and now.waiting:
            self.infeasible = self.got_stuck = True
            return DriveCommand(0.0, 0.0, grasp=True)
        if self._joint.is_futile:
            self.given_up = float(now.pose[2])
            return DriveCommand(0.0, 0.0, grasp=True)
        if not self._plan.done or self._plan.result.cost(now.item_pose(self.item)) >= UNREACHED:
            return self._joint.follow(now, now.intent)
        return self._joint.command(now, now.intent, REST if self._joint.follows else self._planned(now))

    def _planned(self, now: Perception) -> DriveCommand:
        """What the plan wants."""
        assert self._plan is not None
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
                now.space(), now.item(self.item), now.item_pose(self.item), now.robots, places, margin,
                self._planned_goal,
            )  # fmt: skip
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
            ways = np.array(stance_costs(now, self._space, now.partner, self.item))
            if now.intent is not None and ways.min() >= UNREACHED:
                ways[:] = 0.0  # a partner without a way now may have one soon
            theirs = (ways + narrow).tolist()
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
        return options[0] if now.intent is not None and now.partner_item == self.item else None  # the partner may know
