"""A middle item and nobody who helps: one robot drags it, at a tenth of the speed and without turning it."""

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

_LOOK = STRIDE / 2  # units that a try goes
_SETTLED = 3.0  # quarter ticks
_TURNED = 0.08  # rad of turn after which the way is planned anew
_TRIES = 6  # stands that are tried
_DIRECTIONS: Floats = np.arange(24) * math.pi / 12
_STEPS: Floats = _LOOK * np.stack([-np.sin(_DIRECTIONS), np.cos(_DIRECTIONS), np.zeros(24)], axis=1)


class DragPlan:
    """The way of an item with one robot at it, both keeping their angles. The reference point is the item's centre."""

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
        """The heading that leads on."""
        moves = self._body(item_pose) + _STEPS
        costs = costs_at_poses(self.cost_to_go.cost, DRAG_MOTION, moves) + overlap_cost(self._space, self._discs, moves)
        return float(_DIRECTIONS[int(np.argmin(costs))])

    def is_there(self, item_pose: Floats) -> bool:
        """Whether the item is where it should lie."""
        return nearest_cost(self.places, DRAG_MOTION, self._body(item_pose)) <= self.cost(item_pose) + _SETTLED

    def _body(self, item_pose: Floats) -> Floats:
        return np.array([item_pose[0], item_pose[1], 0.0])


class Drag:
    """Bringing a middle item home alone; whoever comes to help may take the other end at any time."""

    def __init__(self, now: Perception, item: int) -> None:
        self.item = item
        self.infeasible = False
        self._goals = goal_boxes(now.map)
        self._space = now.space()
        self._approach: Approach | None = None
        self._choosing: SlicedComputation[Floats | None] = SlicedComputation(self._compute_stance(now))
        self._way: SlicedComputation[DragPlan] | None = None

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Over when the item is home, when it cannot be dragged, or when the partner takes it."""
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
        if self._way is None or (self._way.done and abs(wrap(self._way.result.angle - item_pose[2])) > _TURNED):
            self._way = SlicedComputation(self._compute_plan(now))
        self._way.advance(slices)
        if not self._way.done:
            return REST
        way = self._way.result
        home = is_delivered(now.item(self.item), tuple(item_pose.tolist()), self._goals)
        if (home and way.is_there(item_pose)) or way.cost(item_pose) >= UNREACHED:
            self.infeasible = not home
            return DriveCommand(0.0, 0.0, grasp=True)
        return drive(way.heading(item_pose))

    def _compute_plan(self, now: Perception) -> Computation[DragPlan]:
        space = now.space()
        places = yield from evaluate_places(now, self.item)
        item_pose = now.item_pose(self.item)
        for margin in margins(now.map):
            way = DragPlan(space, now.item(self.item), item_pose, now.pose, places, margin)
            yield
            yield from solve(way.cost_to_go, lambda: way.cost(item_pose))  # noqa: B023
            if way.cost(item_pose) < UNREACHED:
                break
        return way

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
            way = DragPlan(space, spec, item_pose, poses[number], places, margins(now.map)[1])
            yield
            yield from solve(way.cost_to_go, lambda: way.cost(item_pose))  # noqa: B023
            total = costs[number] + 10.0 * way.cost(item_pose)  # it goes at a tenth of the speed
            if way.cost(item_pose) < UNREACHED and (best is None or total < best[0]):
                best = (total, poses[number])
        return best[1] if best is not None else None
