"""Lanes too narrow for two: one robot brings things to a meeting place, the other takes them home from there.

On a locked map nobody can pass anybody, so the robot nearer to the goal stays the nearer one for ever.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from agents.scripted.flood import flood, standing_room, to_bits
from agents.scripted.lattice import UNREACHED, Cost, Field, Motion
from agents.scripted.storage import Point, cells, moved, storage
from agents.scripted.terrain import AXIS, CELLS, Terrain, cell_of, terrain
from agents.scripted.walking import WALKER, Way, grid_of
from maps import MapSpec
from maps.spec import ROBOT_RADIUS
from world.state import Floats

_LOCKED_SHARE = 0.9  # of the places on the way at which a robot blocks it
_STORING = 25.0  # quarter ticks that the outer robot needs besides: into the goal region and out again
_BAND = 14.0  # quarter ticks around the meeting place at which an item may be handed over
_STANDOFF = 50.0  # quarter ticks between the meeting place and the robot that waits for things


@dataclass(frozen=True, slots=True, eq=False)
class Relay:
    """`way_home` (CELLS, CELLS) is the way from anywhere to the goal regions, in quarter ticks."""

    locked: bool
    way_home: Floats
    meeting: float  # on that way

    def left(self, pose: Floats) -> float:
        """The way home from a pose."""
        return float(self.way_home[cell_of(float(pose[0]), float(pose[1]))])

    def waiting_place(self) -> tuple[float, float]:
        """Where the outer robot waits for things."""
        gaps = np.abs(self.way_home - max(self.meeting - _STANDOFF, 0.0))
        row, column = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
        return float(AXIS[column]), float(AXIS[row])

    def is_handed_over(self, item_pose: Floats) -> bool:
        """Whether an item lies where the outer robot fetches it."""
        return self.left(item_pose) <= self.meeting + _BAND + 4.0


def meeting_costs(plan: Relay, motion: Motion, offset: Point) -> Cost:
    """Start costs (headings, CELLS, CELLS) of putting an item down at the meeting place, for `Field.seed`.

    `offset` is the item's centre in the robot's frame. The robot must stand on the far side of it, not on the way home.
    """
    angles = np.arange(motion.headings) * 2 * np.pi / motion.headings
    x, y = moved(offset, angles)
    shape = (motion.headings, CELLS, CELLS)
    item = cells(np.broadcast_to(x, shape), np.broadcast_to(y, shape))
    left = plan.way_home[item]
    off = np.abs(left - plan.meeting)
    behind = plan.way_home[None] > left + 4.0
    return np.where(off <= _BAND, 0.5 * off + np.where(behind, 0.0, 80.0), UNREACHED).astype(np.int16)


@lru_cache(maxsize=64)
def relay(map_spec: MapSpec) -> Relay:
    """What a map is like in this respect, judged from where its first small item starts."""
    bare = terrain(map_spec, ())
    field = Field(bare, ((0.0, 0.0, 0.06),), WALKER, margin=0.0)
    field.seed(np.where(storage(map_spec).inside, 0, UNREACHED).astype(np.int16)[None])
    field.search(4000)
    way_home = grid_of(field).astype(np.float64)
    small = next((item for item in map_spec.items if item.size == "small"), None)
    if small is None:
        return Relay(False, way_home, 0.0)
    start = (small.pose.x, small.pose.y)
    whole = float(way_home[cell_of(*start)])
    return Relay(_is_locked(bare, start), way_home, max((whole - _STORING) / 2, 0.0))


def _is_locked(bare: Terrain, start: tuple[float, float]) -> bool:
    inside = storage(bare.map).inside
    free = standing_room(bare, ROBOT_RADIUS + 0.004)
    goal = to_bits(inside) & free
    rows, columns = np.nonzero(inside & (bare.clearance > ROBOT_RADIUS))
    if not len(rows):
        return False
    middle = len(rows) // 2
    way = Way(bare, [(float(AXIS[columns[middle]]), float(AXIS[rows[middle]]))])
    path = way.path(*start, 400)
    if len(path) < 40:
        return False
    x, y = np.meshgrid(AXIS, AXIS)
    row, column = cell_of(float(path[0, 0]), float(path[0, 1]))
    home = np.zeros((CELLS, CELLS), dtype=np.bool_)
    home[row, column] = True
    places = path[14:-14:4]
    blocked = 0
    for px, py in places:
        left = free & ~to_bits(np.hypot(x - px, y - py) < 2 * ROBOT_RADIUS)
        blocked += not flood(to_bits(home) & left, left) & goal
    return bool(blocked >= _LOCKED_SHARE * len(places))
