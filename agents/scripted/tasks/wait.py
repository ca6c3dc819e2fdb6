"""Waiting: going to a place, and standing aside for the partner."""

import math
from collections.abc import Callable

from movingout.agents.scripted.avoidance import step_aside_plan
from movingout.agents.scripted.carrying.solo_carry import DrivePlan
from movingout.agents.scripted.navigation.motion_choice import REST, CollisionCost, DriveCommand, best_move
from movingout.agents.scripted.navigation.sliced_planning import Computation, SlicedComputation, solve
from movingout.agents.scripted.navigation.walking_route import route_to
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED
from movingout.world.state import Floats

BESIDE = 0.4  # units from a place at which the partner stands


class WalkTo:
    """Going to a place and waiting there."""

    item = -1
    infeasible = False

    def __init__(self, now: Perception, place: tuple[float, float], until: int) -> None:
        self.until = until
        self._route = route_to(now.space(), [place])

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends at the tick `until`."""
        if now.tick >= self.until or now.own_item >= 0:
            return None
        if self._route.cost(float(now.pose[0]), float(now.pose[1])) <= 4.0:
            return REST
        return best_move(now.pose, lambda moves: self._route.costs(moves) + collision_cost(moves))[0]


class ComeTo(WalkTo):
    """Coming near a place that the partner has pointed at, and waiting there."""

    def __init__(self, now: Perception, place: tuple[float, float], until: int) -> None:
        super().__init__(now, place, until)
        self.place = place
        self.infeasible = self._route.cost(float(now.pose[0]), float(now.pose[1])) >= UNREACHED

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends at the tick `until`, and at once where there is no way."""
        if self.infeasible:
            return None
        is_near = math.dist(now.pose[:2].tolist(), self.place) < BESIDE
        return REST if is_near and now.tick < self.until else super().step(now, collision_cost, slices)


class Aside:
    """Standing aside of the partner's path for as long as needed."""

    item = -1
    infeasible = False

    def __init__(
        self,
        now: Perception,
        path: Floats,
        until: int,
        needed: Callable[[Perception], bool] | None = None,
        hands_over: bool = False,
    ) -> None:
        """It lasts until the tick `until`, or as long as `needed` returns True.

        With `hands_over` the robot puts its item down there for the partner.
        """
        self.until = until
        self.handed_over = -1
        self._hands_over = hands_over
        self._needed = needed
        self._held = now.own_item
        self._body: SlicedComputation[DrivePlan] = SlicedComputation(self._compute(now, path))

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends after its time, or when there is no free place."""
        self._body.advance(2 * slices)
        if now.own_item != self._held or (now.tick >= self.until if self._needed is None else not self._needed(now)):
            return None
        if not self._body.done:
            return REST
        body = self._body.result
        here = body.cost(now.pose)
        if here >= UNREACHED:
            return None
        if here < 1.5 and self._hands_over and now.own_item >= 0:
            self.handed_over = now.own_item
            return DriveCommand(0.0, 0.0, grasp=True)
        if here < 1.5:
            return REST
        return body.move(now.pose, collision_cost)

    def _compute(self, now: Perception, path: Floats) -> Computation[DrivePlan]:
        body = step_aside_plan(now, path)
        yield
        yield from solve(body.cost_to_go, lambda: body.cost(now.pose))
        return body
