"""Dragging a middle item alone: at a tenth of the speed and without turning it."""

import math

import numpy as np

from movingout.agents.scripted.carrying.solo_carry import margins
from movingout.agents.scripted.navigation.cost_search import CostToGo, Search
from movingout.agents.scripted.navigation.free_space import FreeSpace, overlap_cost
from movingout.agents.scripted.navigation.geometry import Disc, covering_discs, half_extents, wrap
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.agents.scripted.navigation.motion_choice import REST, STRIDE, CollisionCost, DriveCommand, drive
from movingout.agents.scripted.navigation.pose_grid import DRAG_MOTION, costs_at_poses, nearest_cost
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation, solve
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.goal_places import Places, place_costs
from movingout.agents.scripted.tasks.approach import Approach, stance_costs
from movingout.agents.scripted.tasks.fetch import evaluate_places
from movingout.maps import ItemSpec
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats

_TRIAL_STEP = STRIDE / 2  # units of a trial step
_SETTLED = 3.0  # quarter ticks
_TURNED = 0.08  # rad of turn after which the path is planned again
_TRIES = 6  # stances to evaluate
_DIRECTIONS: Floats = np.arange(24) * math.pi / 12
_STEPS: Floats = _TRIAL_STEP * np.stack([-np.sin(_DIRECTIONS), np.cos(_DIRECTIONS), np.zeros(24)], axis=1)


class DragPlan:
    """The path of an item dragged by one robot, both at constant angles. The reference point is the item's centre."""

    def __init__(
        self, space: FreeSpace, item: ItemSpec, item_pose: Floats, robot: Floats, places: Places, margin: float
    ) -> None:
        cos, sin = math.cos(item_pose[2]), math.sin(item_pose[2])
        self.angle = float(item_pose[2])
        holder = (float(robot[0] - item_pose[0]), float(robot[1] - item_pose[1]))
        self._discs: list[Disc] = [(cos * x - sin * y, sin * x + cos * y, r) for x, y, r in covering_discs(item)]
        self._discs.append((*holder, ROBOT_RADIUS))
        self._space = space
        extents = np.array([half_extents(item, self.angle)])
        starts = place_costs(space, DRAG_MOTION, (0.0, 0.0), extents, [holder], places)
        search = Search(space, self._discs, DRAG_MOTION, margin, starts)
        self.cost_to_go = CostToGo(search)
        self.places = search.starts

    def cost(self, item_pose: Floats) -> float:
        """Quarter ticks at full speed from an item pose."""
        return float(costs_at_poses(self.cost_to_go.cost, DRAG_MOTION, self._body(item_pose)[None])[0])

    def heading(self, item_pose: Floats) -> float:
        """The heading of the next step."""
        moves = self._body(item_pose) + _STEPS
        costs = costs_at_poses(self.cost_to_go.cost, DRAG_MOTION, moves) + overlap_cost(self._space, self._discs, moves)
        return float(_DIRECTIONS[int(np.argmin(costs))])

    def is_there(self, item_pose: Floats) -> bool:
        """Whether the item is at its destination."""
        return nearest_cost(self.places, DRAG_MOTION, self._body(item_pose)) <= self.cost(item_pose) + _SETTLED

    def _body(self, item_pose: Floats) -> Floats:
        return np.array([item_pose[0], item_pose[1], 0.0])


class Drag:
    """Delivering a middle item alone. The partner may grab the other end at any time."""

    def __init__(self, now: Perception, item: int) -> None:
        self.item = item
        self.infeasible = False
        self._goals = goal_boxes(now.map)
        self._space = now.space()
        self._approach: Approach | None = None
        self._choosing: SlicedComputation[Floats | None] = SlicedComputation(self._compute_stance(now))
        self._plan: SlicedComputation[DragPlan] | None = None

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends when the item is delivered, cannot be dragged, or is grabbed by the partner."""
        if now.partner_item == self.item or (now.delivered[self.item] and now.own_item != self.item):
            return None
        if now.own_item != self.item:
            return self._go(now, collision_cost, slices)
        return self._drag(now, slices)

    def _go(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        if now.space() is not self._space:
            return None
        if self._approach is None:
            self._choosing.advance(slices)
            if not self._choosing.done:
                return REST
            if self._choosing.result is None:
                self.infeasible = True
                return None
            self._approach = Approach(self._space, self.item, self._choosing.result)
        return self._approach.step(now, collision_cost)

    def _drag(self, now: Perception, slices: int) -> DriveCommand:
        item_pose = now.item_pose(self.item)
        if self._plan is None or (self._plan.done and abs(wrap(self._plan.result.angle - item_pose[2])) > _TURNED):
            self._plan = SlicedComputation(self._compute_plan(now))
        self._plan.advance(slices)
        if not self._plan.done:
            return REST
        plan = self._plan.result
        home = is_delivered(now.item(self.item), tuple(item_pose.tolist()), self._goals)
        if (home and plan.is_there(item_pose)) or plan.cost(item_pose) >= UNREACHED:
            self.infeasible = not home
            return DriveCommand(0.0, 0.0, grasp=True)
        return drive(plan.heading(item_pose))

    def _compute_plan(self, now: Perception) -> Computation[DragPlan]:
        space = now.space()
        places = yield from evaluate_places(now, self.item)
        item_pose = now.item_pose(self.item)
        for margin in margins(now.map):
            plan = DragPlan(space, now.item(self.item), item_pose, now.pose, places, margin)
            yield
            yield from solve(plan.cost_to_go, lambda: plan.cost(item_pose))  # noqa: B023
            if plan.cost(item_pose) < UNREACHED:
                break
        return plan

    def _compute_stance(self, now: Perception) -> Computation[Floats | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        poses, _ = stances(spec, item_pose)
        costs = stance_costs(now, self._space, now.pose, self.item)
        space = now.space((self.item,))
        places = yield from evaluate_places(now, self.item)
        best: tuple[float, Floats] | None = None
        for number in np.argsort(costs)[:: max(len(costs) // (2 * _TRIES), 1)][:_TRIES].tolist():
            if costs[number] >= UNREACHED:
                break
            plan = DragPlan(space, spec, item_pose, poses[number], places, margins(now.map)[1])
            yield
            yield from solve(plan.cost_to_go, lambda: plan.cost(item_pose))  # noqa: B023
            total = costs[number] + 10.0 * plan.cost(item_pose)  # at a tenth of the speed
            if plan.cost(item_pose) < UNREACHED and (best is None or total < best[0]):
                best = (total, poses[number])
        return best[1] if best is not None else None
