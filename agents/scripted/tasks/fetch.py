"""Small items: fetching one, and carrying it to its place."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.avoidance import meeting_cells, partner_path, side_costs
from movingout.agents.scripted.carrying.solo_carry import Offset, SoloCarryPlan, margins
from movingout.agents.scripted.navigation.free_space import FreeSpace, with_robot
from movingout.agents.scripted.navigation.grasp_stance import GAP, in_frame, stances
from movingout.agents.scripted.navigation.motion_choice import REST, CollisionCost, DriveCommand
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation, solve
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.goal_places import Places
from movingout.agents.scripted.placement.handover_lanes import HandoverLane
from movingout.agents.scripted.tasks.approach import Approach, stance_costs, stance_number
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.shapes import circumradius
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

RELIABLE_COST = 350.0  # quarter ticks: a higher cost may be due to a bad place, so the smaller margin is tried, too
SAVING_WORTH_LITTLE_ROOM = 100.0  # quarter ticks that a path with a small margin must save
_FAR_AHEAD = 150  # cells of the partner's path to the goal to keep off


def evaluate_places(now: Perception, item: int) -> Computation[Places]:
    """The costs of places for an item, given all other items still to be delivered."""
    return _look(now, now.lasting_space(item), item)


def _look(now: Perception, space: FreeSpace, item: int) -> Computation[Places]:
    spec = now.item(item)
    return now.placements.places(space, circumradius(spec.shape, spec.scale), now.remaining(item))


class _Plan(NamedTuple):
    cost: float  # quarter ticks
    carry_plan: SoloCarryPlan


def _plan(
    now: Perception,
    item: int,
    space: FreeSpace,
    offset: Offset,
    handover: HandoverLane | None,
    cost: Callable[[SoloCarryPlan], float],
    fall_back: bool = True,
) -> Computation[_Plan]:
    """The best plan to carry an item to a goal, with a large margin or else a small one.

    Failing both, and with `fall_back`, it is planned as if the delivered items were not there. They cannot be pushed,
    but the robot gets as near as possible and releases the item anywhere in the goal when it stalls.
    """
    places = yield from evaluate_places(now, item)
    best: _Plan | None = None
    for margin in margins(now.map):
        plan = yield from _solved(SoloCarryPlan(space, now.item(item), offset, places, margin, handover), cost)
        if best is None or plan.cost < best.cost - SAVING_WORTH_LITTLE_ROOM:
            best = plan
        if best.cost < RELIABLE_COST:
            break
    assert best is not None  # there is at least one margin
    if best.cost < UNREACHED or handover is not None or not fall_back or not now.delivered.any():
        return best
    space = now.space_without_delivered(item)
    places = yield from _look(now, space, item)
    return (yield from _solved(SoloCarryPlan(space, now.item(item), offset, places, margins(now.map)[-1]), cost))


def _solved(carry_plan: SoloCarryPlan, cost: Callable[[SoloCarryPlan], float]) -> Computation[_Plan]:
    yield
    yield from solve(carry_plan.cost_to_go, lambda: cost(carry_plan))
    return _Plan(cost(carry_plan), carry_plan)


class Fetch:
    """Going to a small item. How it will be carried is planned on the way and decides from which side to grab it."""

    def __init__(
        self,
        now: Perception,
        item: int,
        failed_stances: frozenset[int],
        handover: HandoverLane | None,
        detour: float = 0.0,
        rearranging: bool = False,
        side: float = 0.0,
    ) -> None:
        """`failed_stances`: not to be used again. `handover`: carry the item to this handover point.
        `detour`, `side`: habits of the player (`Style`). `rearranging`: the item may lie in a goal already.
        """
        self._detour = detour
        self._rearranging = rearranging
        self._side = side
        self._theirs = -1
        self.item = item
        self.handover = handover
        self._failed_stances = failed_stances
        self.carry_plan: SoloCarryPlan | None = None
        self.infeasible = False
        self._space = now.space()
        goal = now.item_pose(item)
        self._approach = self._walk_to(np.array([goal[0], goal[1], 0.0]))
        self._planning: SlicedComputation[tuple[SoloCarryPlan, Floats] | None] = SlicedComputation(self._compute(now))
        self._found = False

    @property
    def stance(self) -> int:
        """The chosen stance, -1 while undecided."""
        return stance_number(self._approach.target) if self._found else -1

    def _walk_to(self, target: Floats) -> Approach:
        close = self._space.clearance < ROBOT_RADIUS * (1.0 + self._detour)
        return Approach(self._space, self.item, target, close if self._detour > 0 else None)

    def go_around(self, now: Perception) -> None:
        """Take a route around the partner; keep the current one if there is none."""
        other = Approach(with_robot(self._space, now.partner), self.item, self._approach.target)
        if other.route.cost(float(now.pose[0]), float(now.pose[1])) < UNREACHED:
            self._approach = other

    def take_from_here(self, now: Perception) -> None:
        """Turn to the item and take it from where the robot stands; the partner bars the way to a better place."""
        self._found = True
        self._approach = self._walk_to(now.pose)

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends when the item is held, has moved, or cannot be carried anywhere."""
        if (
            now.own_item == self.item
            or now.partner_item == self.item
            or (now.delivered[self.item] and not self._rearranging)
        ):
            return None
        if not self._found:
            self._planning.advance(slices)
            if self._planning.done:
                self._found = True
                if self._planning.result is None:
                    self.infeasible = True
                    return None
                self.carry_plan, target = self._planning.result
                self._approach = self._walk_to(target)
            elif (self._rearranging and now.intent is not None) or (
                self._approach.route.cost(float(now.pose[0]), float(now.pose[1])) < 24
            ):
                return REST  # what is rearranged may wall the robot in, so that there is no way to its centre
        elif now.space() is not self._space:
            return None
        elif now.partner_item != self._theirs:
            self._theirs = now.partner_item
            if now.partner_item >= 0 and not now.is_heavy(now.partner_item):
                self._avoid_partner_path(now)
        return self._approach.step(now, collision_cost)

    def _avoid_partner_path(self, now: Perception) -> None:
        """Avoid the path on which the partner delivers its item, unless that is a large detour."""
        path = partner_path(now, -1, _FAR_AHEAD)
        self._approach = Approach(self._space, self.item, self._approach.target, meeting_cells(path))

    def _compute(self, now: Perception) -> Computation[tuple[SoloCarryPlan, Floats] | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        poses, _ = stances(spec, item_pose)
        walks = np.array(stance_costs(now, self._space, now.pose, self.item, self._failed_stances))
        walks += side_costs(now, self.item, self._side)
        reachable = walks < UNREACHED
        yield
        if not reachable.any():
            return None
        offset = (0.0, ROBOT_RADIUS + GAP + spec.scale, 0.0)

        def cost(carry_plan: SoloCarryPlan) -> float:
            return float((walks + carry_plan.costs_at(poses))[reachable].min())

        plan = yield from _plan(now, self.item, now.space((self.item,)), offset, self.handover, cost)
        number = int(np.argmin(walks + plan.carry_plan.costs_at(poses)))
        return (plan.carry_plan, poses[number]) if plan.cost < UNREACHED else None


class Carry:
    """Carrying a small item to its place."""

    def __init__(
        self, now: Perception, item: int, carry_plan: SoloCarryPlan | None, handover: HandoverLane | None
    ) -> None:
        """`carry_plan` is the plan made while fetching, if there is one."""
        self.item = item
        self.infeasible = False
        self.handover = handover
        self._carry_plan = carry_plan
        self._planning: SlicedComputation[SoloCarryPlan] | None = None
        self._space = now.space() if carry_plan is not None else None
        self._goes_around = False

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends when the gripper is empty."""
        if now.own_item != self.item:
            return None
        if now.space() is not self._space:
            self._space = now.space()
            self._planning = SlicedComputation(self._compute(now, self._space))
            self._goes_around = False
        if self._planning is not None:
            self._planning.advance(slices)
            if self._planning.done:
                other, self._planning = self._planning.result, None
                if self._carry_plan is None or not self._goes_around or other.cost(now.pose) < UNREACHED:
                    self._carry_plan = other
                self._goes_around = False
        if self._carry_plan is None:
            return REST
        return self._carry_plan.drive(
            now.pose, now.item_pose(self.item), collision_cost, now.anticipates, only_there=now.intent is not None
        )

    def go_around(self, now: Perception) -> None:
        """Plan a path around the partner as an obstacle; keep the current one if there is none."""
        self._goes_around = True
        self._planning = SlicedComputation(self._compute(now, with_robot(now.space(), now.partner)))

    def _compute(self, now: Perception, space: FreeSpace) -> Computation[SoloCarryPlan]:
        offset = in_frame(now.pose, now.item_pose(self.item))
        fall_back = not self._goes_around  # the partner will move eventually
        plan = yield from _plan(
            now, self.item, space, offset, self.handover, lambda carry_plan: carry_plan.cost(now.pose), fall_back
        )
        return plan.carry_plan
