"""The paper's reward for learning (appendix "Dense Reward Setting", its table's rows A to D).

`world.official_reward` has what the official code pays instead; the two differ in more than scale.
Where the table leaves something open: "inside a goal" is what the score counts as delivered; distances are
those of the 48 x 48 grid; a held item's own distance to the goal counts, or with `carrier=True` that of the robot that
holds it, as the text has it ("the agent's distance to the current target"); on the tick of a grab or release only
events are paid, because the target changes; "another agent needs help" (row C) is about another item than the one
that is released, so that letting go of an item held together brings no reward for help.
"""

import math

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.shapes import box_sides
from movingout.world.distance import Cell, gained, paper_distances
from movingout.world.scoring import goal_boxes, is_delivered
from movingout.world.state import Floats, WorldState

GAMMA = 20.0  # per unit of distance gained
HOLD, HOLD_UNWANTED = 0.5, -0.5
RELEASE_INSIDE, RELEASE_OUTSIDE, RELEASE_TO_HELP = 0.5, -0.5, 0.5
STEP_COST = -0.01


class _Moment:
    """What the reward needs to know of one state, each thing worked out when first asked for.

    Items that lie where they lay in the state `last` keep what was worked out then.
    """

    def __init__(self, grid: "_Grid", state: WorldState, last: "_Moment | None") -> None:
        self.state = state
        self.held: list[int] = state.held.tolist()
        self._grid = grid
        self._robots = [grid.distances.cell(x, y) for x, y, _ in state.robot_poses.tolist()]
        self._poses: list[list[float]] = state.item_poses.tolist()
        self._nearest: dict[tuple[int, tuple[int, ...]], float] = {}
        self._floods: dict[tuple[int, ...], list[Floats]] = {}
        self._points: list[list[Cell] | None] = [None] * len(self._poses)
        self.home: list[bool] = []
        if last is None:
            self.home = [grid.is_home(item, pose) for item, pose in enumerate(self._poses)]
        elif last._poses == self._poses:
            self.home, self._points, self._floods = last.home, last._points, last._floods
        else:
            self._take_over(last)

    def _take_over(self, last: "_Moment") -> None:
        """What was worked out for the items that did not move."""
        self.home, self._points = last.home.copy(), last._points.copy()
        for item, (pose, before) in enumerate(zip(self._poses, last._poses, strict=True)):
            if pose != before:
                self.home[item] = self._grid.is_home(item, pose)
                self._points[item] = None

    def to_goal(self, item: int) -> float:
        """From the item's centre to the nearest goal."""
        x, y, _ = self._poses[item]
        return self._grid.distances.cell_to_goal(self._grid.distances.cell(x, y))

    def robot_to_goal(self, seat: int) -> float:
        """From the robot's centre to the nearest goal."""
        return self._grid.distances.cell_to_goal(self._robots[seat])

    def reach(self, seat: int, targets: tuple[int, ...]) -> float:
        """From the robot's centre to the nearest of the targets' holding points."""
        nearest = self._nearest.get((seat, targets))  # asked again as the state before the next tick
        if nearest is None:
            robot, floods = self._robots[seat], self._floods.get(targets) or self._flooded(targets)
            nearest = min([flood.item(robot) for flood in floods], default=math.inf)
            self._nearest[seat, targets] = nearest
        return nearest

    def _flooded(self, targets: tuple[int, ...]) -> list[Floats]:
        """The distances to each of the targets' holding points."""
        to_cell = self._grid.distances.to_cell
        floods = [to_cell(point) for item in targets for point in self._points[item] or self._found(item)]
        self._floods[targets] = floods
        return floods

    def _found(self, item: int) -> list[Cell]:
        points = self._points[item] = self._grid.holding_cells(item, self._poses[item])
        return points


class _Grid:
    """A map's items and goals on the 48 x 48 grid."""

    def __init__(self, map_spec: MapSpec) -> None:
        self.distances = paper_distances(map_spec)
        self._items = map_spec.items
        self._goals = goal_boxes(map_spec)

    def is_home(self, item: int, pose: list[float]) -> bool:
        """Whether an item in a pose (x, y, angle) is delivered."""
        return is_delivered(self._items[item], tuple(pose), self._goals)

    def holding_cells(self, item: int, pose: list[float]) -> list[Cell]:
        """The points to approach: an item's centre, a large rectangle's two short sides.

        The paper pays for the short sides on one map, so that the two grasp the ends and fit through; it names
        Four Corners, whose items are no rectangles, so here it goes by the item.
        """
        x, y, angle = pose
        spec = self._items[item]
        if spec.shape != "rectangle" or spec.size != "large":
            return [self.distances.cell(x, y)]
        half = box_sides(spec.shape, spec.scale)[0] / 2
        dx, dy = half * math.cos(angle), half * math.sin(angle)
        return [self.distances.cell(x + dx, y + dy), self.distances.cell(x - dx, y - dy)]


class PaperReward:
    """The reward of a tick from the states around it; `dense=False` leaves out row A, the distances.

    `carrier`: a full hand is paid for its robot's way to a goal, not for its item's.
    Fast when asked tick by tick: the state after a tick is that before the next.
    """

    def __init__(self, map_spec: MapSpec, dense: bool = True, carrier: bool = False) -> None:
        self.map = map_spec
        self.dense = dense
        self.carrier = carrier
        self._grid = _Grid(map_spec)
        self._big = [item.size != "small" for item in map_spec.items]
        self._last: _Moment | None = None

    def __call__(self, before: WorldState, after: WorldState) -> Floats:
        """The reward (2,) of the tick between two states: blue's, red's."""
        then = self._last
        if then is None or then.state is not before:
            then = _Moment(self._grid, before, None)
        now = then if after is before else _Moment(self._grid, after, then)
        self._last = now
        return np.array([self._of(seat, then, now) for seat in (0, 1)])

    def _of(self, seat: int, then: _Moment, now: _Moment) -> float:
        held, holds = then.held[seat], now.held[seat]
        partner_held, partner_holds = then.held[1 - seat], now.held[1 - seat]
        if held < 0 and holds >= 0:
            unwanted = then.home[holds] or self._is_other_big(partner_held, holds)
            return STEP_COST + (HOLD_UNWANTED if unwanted else HOLD)
        if held >= 0 and holds < 0:
            needed = self._is_other_big(partner_holds, held) and not now.home[partner_holds]
            event = RELEASE_INSIDE if now.home[held] else RELEASE_OUTSIDE
            return STEP_COST + event + (RELEASE_TO_HELP if needed else 0.0)
        if not self.dense:
            return STEP_COST
        if holds >= 0 and self.carrier:
            return STEP_COST + GAMMA * gained(then.robot_to_goal(seat), now.robot_to_goal(seat))
        if holds >= 0:
            return STEP_COST + GAMMA * gained(then.to_goal(held), now.to_goal(holds))
        targets = self._targets((partner_held, partner_holds), then.home, now.home)
        return STEP_COST + GAMMA * gained(then.reach(seat, targets), now.reach(seat, targets))

    def _targets(self, partners: tuple[int, int], was_home: list[bool], is_home: list[bool]) -> tuple[int, ...]:
        """What an empty hand should go to: the partner's item if it needs help, else the free items."""
        held, holds = partners
        if held == holds and holds >= 0 and self._big[holds] and not (was_home[holds] or is_home[holds]):
            return (holds,)
        free = [
            item
            for item, (was, is_) in enumerate(zip(was_home, is_home, strict=True))
            if not (was or is_ or item in partners)
        ]
        return tuple(free)

    def _is_other_big(self, partners: int, own: int) -> bool:
        """Whether the partner has a middle or large item that is not the one in the own hand."""
        return partners not in (-1, own) and self._big[partners]
