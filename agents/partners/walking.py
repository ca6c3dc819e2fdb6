"""What simple partners share: walking around obstacles, grabbing what is ahead, and getting unstuck.

They look a few cells ahead along the cheapest way to a point. They search no poses, pack nothing and predict nobody.
"""

import math
from functools import lru_cache
from random import Random

from movingout.agents.scripted.navigation.free_space import FreeSpace, cell_of
from movingout.agents.scripted.navigation.geometry import heading_of, signed_distance, wrap
from movingout.agents.scripted.navigation.grasp_stance import within_reach
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand, drive, turn_to
from movingout.agents.scripted.navigation.walking_route import route_to
from movingout.agents.scripted.perception import FreeSpaceCache, Perception
from movingout.maps import MapSpec
from movingout.maps.shapes import circumradius
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats, WorldState

Point = tuple[float, float]

AHEAD = 5  # cells of the way that are looked ahead
STUCK_AFTER = 7  # ticks
STUCK_WITHIN = 0.04  # units in STUCK_AFTER ticks: less is stuck
STUCK_TURN = 0.3  # rad in STUCK_AFTER ticks, likewise
LOOSENS_FOR = 5  # ticks of a random drive that gets it unstuck
STUCK_AGAIN = 50  # ticks
LONGEST = 4  # times LOOSENS_FOR
_IN_FRONT = ROBOT_RADIUS + 0.07  # units from an item's surface at which it is turned to
_BESIDE = ROBOT_RADIUS + 0.02  # units from an item's outline
_ROUND = [turn * math.pi / 6 for turn in range(12)]
_TURNS_WITHIN = 0.35  # units from its goal at which it turns what it carries ahead
_FACING = 0.3  # rad off the item's direction within which it drives on to it


class Perceiver:
    """What one simple partner sees in one episode; it keeps the free spaces that it has worked out."""

    def __init__(self, the_map: MapSpec, seat: int) -> None:
        self._map = the_map
        self._seat = seat
        self._floors: FreeSpaceCache = {}

    def perceive(self, state: WorldState) -> Perception:
        """A state as seen from the seat."""
        return Perception(self._map, state, self._seat, free_spaces=self._floors)


class StuckRecovery:
    """Gets a robot unstuck that was to move and did not; only how it does so is random."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._trail: list[Floats] = []
        self._loosening: list[DriveCommand] = []
        self._stuck_at, self._longer = -STUCK_AGAIN, 1

    def unstuck(self, now: Perception, command: DriveCommand) -> DriveCommand:
        """The command, or a random drive for some ticks when the robot was to move and did not."""
        if self._loosening:
            return self._loosening.pop()
        if command.grasp or command.distance == 0.0:
            self._trail = []
            return command
        self._trail = [*self._trail[-STUCK_AFTER:], now.pose]
        if len(self._trail) > STUCK_AFTER and self._is_stuck(now):
            self._trail = []
            heading = float(now.pose[2]) + self._random.uniform(-2.5, 2.5)
            backward = -1.0 if self._random.random() < 0.6 else 1.0
            again = now.tick - self._stuck_at < STUCK_AGAIN
            self._longer = min(self._longer + 1, LONGEST) if again else 1  # who is stuck again goes farther away
            self._stuck_at = now.tick
            self._loosening = self._longer * LOOSENS_FOR * [DriveCommand(backward, heading)]
        return command

    def _is_stuck(self, now: Perception) -> bool:
        first = self._trail[0]
        return _apart(first, now.pose) < STUCK_WITHIN and abs(float(now.pose[2] - first[2])) < STUCK_TURN


def walk(now: Perception, space: FreeSpace, targets: list[Point]) -> DriveCommand:
    """One step along the cheapest way to the nearest of some points; rests when there.

    With something in the hand it drives whichever way needs less turning, since the item may have no room to swing.
    """
    command = drive_along(now.pose, space, targets)
    near = min(math.dist(now.pose[:2].tolist(), target) for target in targets) < _TURNS_WITHIN
    if now.own_item >= 0 and not near and abs(wrap(command.heading - float(now.pose[2]))) > math.pi / 2:
        return drive(command.heading + math.pi, -command.distance)
    return command


def drive_along(start: Floats, space: FreeSpace, targets: list[Point]) -> DriveCommand:
    """The robot drives as the way from `start`, where it or its item is, to the nearest of some points goes."""
    x, y = float(start[0]), float(start[1])
    path = route_to(space, targets).path(x, y, AHEAD)
    dx, dy = float(path[-1, 0]) - x, float(path[-1, 1]) - y
    if len(path) < 2 or math.hypot(dx, dy) < 0.02:
        nearest = min(targets, key=lambda target: math.dist((x, y), target))
        dx, dy = nearest[0] - x, nearest[1] - y  # into the obstacle in which it lies, or straight on
    return drive(heading_of(dx, dy)) if math.hypot(dx, dy) > 0.02 else REST


def go_and_grab(now: Perception, item: int) -> DriveCommand:
    """Walk to an item, turn to it and take it where it comes within reach."""
    goal = now.item_pose(item)
    to_item = heading_of(float(goal[0] - now.pose[0]), float(goal[1] - now.pose[1]))
    if within_reach(now.item(item), goal, now.pose):
        return DriveCommand(0.0, float(now.pose[2]), grasp=True)
    surface = float(signed_distance(now.item(item), goal, now.pose[None, :2])[0])
    if surface < _IN_FRONT:
        off = abs(wrap(to_item - float(now.pose[2])))
        return drive(to_item, 0.4) if off < _FACING else turn_to(to_item)
    return walk(now, now.space(), places_beside(now, item))


def way_length(now: Perception, item: int) -> float:
    """Quarter ticks of walking to beside an item, large where there is no way."""
    return route_to(now.space(), places_beside(now, item)).cost(float(now.pose[0]), float(now.pose[1]))


def places_beside(now: Perception, item: int) -> list[Point]:
    """Points all around an item where a robot has room; the item's middle where it has none."""
    x, y, _ = now.item_pose(item).tolist()
    away = circumradius(now.item(item).shape, now.item(item).scale) + _BESIDE
    return list(_places_around(now.space(), x, y, away))


@lru_cache(maxsize=64)
def _places_around(space: FreeSpace, x: float, y: float, away: float) -> tuple[Point, ...]:
    ring = [(x + away * math.cos(turn), y + away * math.sin(turn)) for turn in _ROUND]
    return tuple(place for place in ring if space.clearance[cell_of(*place)] > ROBOT_RADIUS) or ((x, y),)


def goal_centres(the_map: MapSpec) -> list[Point]:
    """The middle of each goal region."""
    return [((goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2) for goal in the_map.goals]


def _apart(one: Floats, other: Floats) -> float:
    return math.dist(one[:2].tolist(), other[:2].tolist())
