"""Small items: going to one, and bringing it to its place."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.carrying.solo_carry import Haul, Offset, margins
from movingout.agents.scripted.navigation.grasp_stance import GAP, in_frame, stands
from movingout.agents.scripted.navigation.motion_choice import REST, Command, Danger
from movingout.agents.scripted.navigation.sliced_planning import Thinking, Thought, solve
from movingout.agents.scripted.navigation.terrain import Terrain, with_robot
from movingout.agents.scripted.placement.goal_places import Places
from movingout.agents.scripted.placement.handover_lanes import Relay
from movingout.agents.scripted.situation import Situation
from movingout.agents.scripted.tasks.approach import Approach, stand_number, walk_costs
from movingout.agents.scripted.traffic import around, partners_way, side_prices
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.shapes import circumradius
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

HONEST = 350.0  # quarter ticks: a dearer way may come from a bad place to put the item down
WORTH_SQUEEZING = 100.0  # quarter ticks that a way with hardly any room must save
_FAR_AHEAD = 150  # cells of the partner's way home that one had better not meet it on


def look_around(now: Situation, item: int) -> Thought[Places]:
    """What the places for an item are worth, with everything else that is still to come."""
    return _look(now, now.lasting_ground(item), item)


def _look(now: Situation, ground: Terrain, item: int) -> Thought[Places]:
    spec = now.item(item)
    return now.looks.places(ground, circumradius(spec.shape, spec.scale), now.outlook(item))


class _Plan(NamedTuple):
    cost: float  # quarter ticks
    haul: Haul


def _plan(
    now: Situation,
    item: int,
    ground: Terrain,
    offset: Offset,
    meeting: Relay | None,
    cost: Callable[[Haul], float],
    insists: bool = True,
) -> Thought[_Plan]:
    """How to bring an item home: with much room, else with little.

    Else as if what is delivered were not there: nothing that lies can be pushed, but one gets as near as it goes, and
    whoever is not getting any nearer lets go wherever it counts.
    """
    look = yield from look_around(now, item)
    best: _Plan | None = None
    for margin in margins(now.map):
        plan = yield from _solved(Haul(ground, now.item(item), offset, look, margin, meeting), cost)
        if best is None or plan.cost < best.cost - WORTH_SQUEEZING:
            best = plan
        if best.cost < HONEST:
            break
    assert best is not None  # there are margins
    if best.cost < UNREACHED or meeting is not None or not insists or not now.delivered.any():
        return best
    ground = now.ground_without_delivered(item)
    look = yield from _look(now, ground, item)
    return (yield from _solved(Haul(ground, now.item(item), offset, look, margins(now.map)[-1]), cost))


def _solved(haul: Haul, cost: Callable[[Haul], float]) -> Thought[_Plan]:
    yield
    yield from solve(haul.field, lambda: cost(haul))
    return _Plan(cost(haul), haul)


class Fetch:
    """Going to a small item; knows on the way how it will be carried, and so from which side to take it."""

    def __init__(
        self,
        now: Situation,
        item: int,
        useless: frozenset[int],
        meeting: Relay | None,
        detour: float = 0.0,
        tidying: bool = False,
        side: float = 0.0,
    ) -> None:
        """With `meeting` it is going to be handed over there; with `tidying` it may lie in a goal already.

        `useless` are stands that have failed; `detour` is how much the player dislikes to walk close to walls, and
        `side` from where it likes to grab.
        """
        self._detour = detour
        self._tidying = tidying
        self._side = side
        self._theirs = -1
        self.item = item
        self.meeting = meeting
        self._useless = useless
        self.haul: Haul | None = None
        self.hopeless = False
        self._ground = now.ground()
        self._item_pose = now.item_pose(item)
        goal = now.item_pose(item)
        self._approach = self._walk_to(np.array([goal[0], goal[1], 0.0]))
        self._thinking: Thinking[tuple[Haul, Floats] | None] = Thinking(self._think(now))
        self._found = False

    @property
    def stand(self) -> int:
        """The stand it is about to use, -1 while undecided."""
        return stand_number(self._approach.target) if self._found else -1

    def _walk_to(self, target: Floats) -> Approach:
        close = self._ground.clearance < ROBOT_RADIUS * (1.0 + self._detour)
        return Approach(self._ground, self.item, target, close if self._detour > 0 else None)

    def go_around(self, now: Situation) -> None:
        """Look for a way around the partner; stay on the old one where there is none."""
        other = Approach(with_robot(self._ground, now.partner), self.item, self._approach.target)
        if other.way.cost(float(now.pose[0]), float(now.pose[1])) < UNREACHED:
            self._approach = other

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the item is in a hand, has moved, or cannot be brought anywhere."""
        if now.mine == self.item or now.theirs == self.item or (now.delivered[self.item] and not self._tidying):
            return None
        if not self._found:
            self._thinking.advance(slices)
            if self._thinking.done:
                self._found = True
                if self._thinking.result is None:
                    self.hopeless = True
                    return None
                self.haul, target = self._thinking.result
                self._approach = self._walk_to(target)
            elif self._approach.way.cost(float(now.pose[0]), float(now.pose[1])) < 24:
                return REST
        elif now.ground() is not self._ground:
            return None
        elif now.theirs != self._theirs:
            self._theirs = now.theirs
            if now.theirs >= 0 and not now.is_heavy(now.theirs):
                self._take_another_way(now)
        return self._approach.step(now, danger)

    def _take_another_way(self, now: Situation) -> None:
        """Keep off the way on which the partner brings its item home, where that is no great detour."""
        way = partners_way(now, -1, _FAR_AHEAD)
        self._approach = Approach(self._ground, self.item, self._approach.target, around(way))

    def _think(self, now: Situation) -> Thought[tuple[Haul, Floats] | None]:
        spec, item_pose = now.item(self.item), now.item_pose(self.item)
        poses, _ = stands(spec, item_pose)
        walks = np.array(walk_costs(now, self._ground, now.pose, self.item, self._useless))
        walks += side_prices(now, self.item, self._side)
        reachable = walks < UNREACHED
        yield
        if not reachable.any():
            return None
        offset = (0.0, ROBOT_RADIUS + GAP + spec.scale, 0.0)

        def cost(haul: Haul) -> float:
            return float((walks + haul.costs_at(poses))[reachable].min())

        plan = yield from _plan(now, self.item, now.ground((self.item,)), offset, self.meeting, cost)
        number = int(np.argmin(walks + plan.haul.costs_at(poses)))
        return (plan.haul, poses[number]) if plan.cost < UNREACHED else None


class Carry:
    """Bringing a small item to its place."""

    def __init__(self, now: Situation, item: int, haul: Haul | None, meeting: Relay | None) -> None:
        """`haul` is the plan made while fetching it, if it still serves."""
        self.item = item
        self.hopeless = False
        self.meeting = meeting
        self._haul = haul
        self._thinking: Thinking[Haul] | None = None
        self._ground = now.ground() if haul is not None else None
        self._goes_around = False

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """Over when the hand is empty."""
        if now.mine != self.item:
            return None
        if now.ground() is not self._ground:
            self._ground = now.ground()
            self._thinking = Thinking(self._think(now, self._ground))
            self._goes_around = False
        if self._thinking is not None:
            self._thinking.advance(slices)
            if self._thinking.done:
                other, self._thinking = self._thinking.result, None
                if self._haul is None or not self._goes_around or other.cost(now.pose) < UNREACHED:
                    self._haul = other
                self._goes_around = False
        if self._haul is None:
            return REST
        return self._haul.drive(now.pose, now.item_pose(self.item), danger, now.foresees)

    def go_around(self, now: Situation) -> None:
        """Look for a way around the partner as something that stands there; stay on the old one if there is none."""
        self._goes_around = True
        self._thinking = Thinking(self._think(now, with_robot(now.ground(), now.partner)))

    def _think(self, now: Situation, ground: Terrain) -> Thought[Haul]:
        offset = in_frame(now.pose, now.item_pose(self.item))
        insists = not self._goes_around  # the partner will not stand there for good
        plan = yield from _plan(now, self.item, ground, offset, self.meeting, lambda haul: haul.cost(now.pose), insists)
        return plan.haul
