"""What the partner means to do, read from how it moves: to which item it goes, and where it pulls a shared one.

Two robots that hold one item move it by the mean of both commands (measured: to 0.05 u/s, away from walls). So the
partner's command is twice the mean velocity less the own command.
"""

import math
from collections import deque

import numpy as np

from movingout.agents.scripted.navigation.free_space import free_space
from movingout.agents.scripted.navigation.motion_choice import TURN_IN_PLACE, DriveCommand
from movingout.agents.scripted.navigation.walking_route import WalkingRoute, cost_at, route_to
from movingout.maps import MapSpec
from movingout.world.constants import DRIVE_SPEED
from movingout.world.state import Floats, WorldState

_WINDOW = 8  # ticks of its path from which the partner is read
_MEANT = 14.0  # quarter ticks of way in the window that make an item the partner's aim: of 32 at full speed
_COMES = 8.0  # quarter ticks of way in the window with which it is coming
_ALIKE = 4.0  # quarter ticks: aims within this are told apart by which is nearer
_BESIDE = 0.42  # units from an item within which the partner is about to take it
_BESIDE_FOR = 25  # ticks for which that is believed
_SMOOTHING = 0.5  # weight of the newest estimate of a pull


class PartnerIntent:
    """The partner of one seat in one episode, as read from the states."""

    def __init__(self, the_map: MapSpec, seat: int) -> None:
        self._map = the_map
        self._seat = seat
        self._walls = free_space(the_map, ())
        self._path: deque[tuple[float, float]] = deque(maxlen=_WINDOW + 1)
        self._own = np.zeros(2)  # the own command of the last tick [u/s]
        self._shared = -1  # the item that both hold
        self._beside: dict[int, int] = {}  # by item: ticks for which the partner has been beside it
        self.pull: Floats = np.zeros(2)  # the partner's command while both hold an item [u/s]
        self.holds_since = 0  # the tick since which its hand is as it is
        self._held = -1
        self._tick = 0

    def observe(self, state: WorldState) -> None:
        """Take note of the state before a tick."""
        theirs, mine = int(state.held[1 - self._seat]), int(state.held[self._seat])
        x, y, _ = state.robot_poses[1 - self._seat].tolist()
        self._path.append((x, y))
        self._tick = state.tick
        if theirs != self._held:
            self._held, self.holds_since = theirs, state.tick
        for item, (ix, iy, _) in enumerate(state.item_poses.tolist()):
            beside = math.hypot(ix - x, iy - y) < _BESIDE
            self._beside[item] = self._beside.get(item, 0) + 1 if beside else 0
        if theirs < 0 or theirs != mine:
            self.pull, self._shared = np.zeros(2), -1
        elif self._shared < 0:
            self._shared = theirs  # the velocities are those from before the grasp
        else:
            felt = 2 * state.robot_velocities[:, :2].mean(axis=0) - self._own
            felt *= min(1.0, DRIVE_SPEED / max(float(np.hypot(*felt)), 1e-9))
            self.pull = (1 - _SMOOTHING) * self.pull + _SMOOTHING * felt

    def commanded(self, command: DriveCommand) -> None:
        """Take note of the own command for the coming tick."""
        speed = DRIVE_SPEED * command.distance if abs(command.distance) > TURN_IN_PLACE else 0.0
        self._own = speed * np.array([-math.sin(command.heading), math.cos(command.heading)])

    def approach(self, state: WorldState, item: int) -> float:
        """Quarter ticks by which the partner's way to an item has become shorter in the last ticks."""
        route = self._route(state, item)
        return cost_at(route.lengths, *self._path[0]) - cost_at(route.lengths, *self._path[-1])

    def is_coming(self, state: WorldState, item: int) -> bool:
        """Whether the partner is on its way to an item, or stands at it and is about to take it."""
        if int(state.held[1 - self._seat]) >= 0:
            return False
        return 0 < self._beside[item] < _BESIDE_FOR or self.approach(state, item) > _COMES

    def meant(self, state: WorldState, items: list[int]) -> int:
        """Which of some items the partner goes to; -1 when it cannot be told or its hand is full."""
        if int(state.held[1 - self._seat]) >= 0 or len(self._path) <= _WINDOW:
            return -1
        nearer = {item: self.approach(state, item) for item in items}
        most = max(nearer.values(), default=0.0)
        if most < _MEANT:
            return -1
        x, y = self._path[-1]
        alike = [item for item, cost in nearer.items() if cost > most - _ALIKE]
        return min(alike, key=lambda item: (cost_at(self._route(state, item).lengths, x, y), item))

    def goal_pulled_to(self, state: WorldState, item: int) -> int:
        """The goal to which the partner pulls a shared item; -1 when that is no region's direction."""
        x, y, _ = state.item_poses[item].tolist()
        towards = [_cosine(self.pull, self._way(goal.left, goal.right, goal.bottom, goal.top, x, y))
                   for goal in self._map.goals]  # fmt: skip
        best = int(np.argmax(towards))
        return best if towards[best] > 0.3 else -1

    def _way(self, left: float, right: float, bottom: float, top: float, x: float, y: float) -> Floats:
        """(2,) the direction of the way from a point to a goal."""
        path = route_to(self._walls, [((left + right) / 2, (bottom + top) / 2)]).path(x, y, 6)
        return np.asarray(path[-1] - path[0])

    def _route(self, state: WorldState, item: int) -> WalkingRoute:
        x, y, _ = state.item_poses[item].tolist()
        return route_to(self._walls, [(round(x, 1), round(y, 1))])


def _cosine(one: Floats, other: Floats) -> float:
    lengths = float(np.hypot(*one) * np.hypot(*other))
    return float(one @ other) / lengths if lengths > 1e-6 else 0.0
