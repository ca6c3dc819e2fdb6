"""The layouts `official-v1` and `map-v1`: what a seat sees as poses, as the official encoder writes them.

Layout `official-v1`, 121 numbers, equal to the bit to the official StatesEncoder, so that official data and
policies carry over:

| index | what |
|---|---|
| 0-7 | own robot: x, y, cos, sin of the angle, holding (+1 yes, -1 no), vx, vy [units/s], angular velocity [rad/s] |
| 8-15 | the other robot, likewise |
| 16 + 15 i | item i of the map (i = 0-6): x, y, cos, sin of the angle, |
| + 4-11 | its shape, one-hot: triangle, square, pentagon, hexagon, octagon, circle, star, rectangle, |
| + 12-14 | its size, one-hot: small, middle, large |

Layout `map-v1`, 169 numbers, is `official-v1` and then what the paper adds for one policy on several maps
("Observation Encoding"): the top-left and the bottom-right corner of each wall and goal.

| index | what |
|---|---|
| 121 + 4 j | wall j (j = 0-7): left, top, right, bottom |
| 153 + 4 k | goal k (k = 0-3): left, top, right, bottom, as drawn |

Unused slots are 0. Which item is held, an item's velocity, its mass and exact scale are not in the vector, as in
the official one.
"""

from dataclasses import dataclass

import numpy as np

from movingout.maps import MapSpec, Rect
from movingout.maps.spec import ARENA_HALF, SHAPES, SIZES
from movingout.world.observation.slots import Slots
from movingout.world.state import Floats, Ints, WorldState

ROBOT_WIDTH = 8
ITEM_WIDTH = 4 + len(SHAPES) + len(SIZES)
ITEM_SLOTS = 7
_ITEMS_START = 2 * ROBOT_WIDTH
POSITION = 2 * ARENA_HALF  # [u] bounds of what is seen
SPEED, SPIN = 100.0, 1000.0  # [u/s], [rad/s]


@dataclass(frozen=True, slots=True)
class ObservationLayout:
    """How many slots a vector has behind its 121 official numbers."""

    name: str
    wall_slots: int
    goal_slots: int

    @property
    def size(self) -> int:
        """D, the length of the vector."""
        return _ITEMS_START + ITEM_SLOTS * ITEM_WIDTH + 4 * (self.wall_slots + self.goal_slots)

    @property
    def slots(self) -> Slots:
        """What fits; a layout without walls and goals is for any number of them."""
        return Slots(ITEM_SLOTS, self.wall_slots or None, self.goal_slots or None)

    @property
    def bounds(self) -> Floats:
        """(D,) how large each number can be, up or down."""
        robot = [POSITION, POSITION, 1.0, 1.0, 1.0, SPEED, SPEED, SPIN]
        item = [POSITION, POSITION] + [1.0] * (ITEM_WIDTH - 2)
        corners = [POSITION] * 4 * (self.wall_slots + self.goal_slots)
        return np.array([*2 * robot, *ITEM_SLOTS * item, *corners])


OFFICIAL, WITH_MAP = ObservationLayout("official-v1", 0, 0), ObservationLayout("map-v1", 8, 4)


class Encoder:
    """Encodes the states of one map in one layout; what never changes on the map is written once.

    Everything that moves is laid out in one row, from which one gather per seat fills the vector.
    """

    def __init__(self, map_spec: MapSpec, layout: ObservationLayout = OFFICIAL) -> None:
        """Raises WorldError for a map that has more of something than the layout has slots."""
        self.map = map_spec
        self.layout = layout
        self._constants = _template(map_spec, self.layout)
        self._sources = tuple(_sources(len(map_spec.items), self._constants.size, seat) for seat in (0, 1))

    def encode(self, state: WorldState, seat: int) -> Floats:
        """The vector (D,) that `seat` sees, as a new array."""
        return self.encode_arrays(state.robot_poses, state.robot_velocities, state.held, state.item_poses, seat)

    def encode_both(self, state: WorldState) -> tuple[Floats, Floats]:
        """What blue and red see, (D,) each, at little more than the cost of one."""
        row = self._row(state.robot_poses, state.robot_velocities, state.held, state.item_poses)
        return row.take(self._sources[0]), row.take(self._sources[1])

    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> Floats:
        """The vectors (..., D) of states given as arrays: (..., 2, 3), (..., 2, 3), (..., 2) and (..., N, 3)."""
        row = self._row(robot_poses, robot_velocities, held, item_poses)
        return row.take(self._sources[seat], axis=-1)

    def _row(self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats) -> Floats:
        """All there is, (..., S): poses of robots and items, velocities, cosines, sines, hold signs, constants."""
        leading = robot_poses.shape[:-2]
        poses = np.concatenate((robot_poses, item_poses), axis=-2)
        angles = poses[..., 2]
        constants = self._constants if not leading else np.broadcast_to(self._constants, (*leading, self.layout.size))
        return np.concatenate(
            (
                poses.reshape(*leading, -1),
                robot_velocities.reshape(*leading, 6),
                np.cos(angles),
                np.sin(angles),
                np.sign(held + 0.5),
                constants,
            ),
            axis=-1,
        )


def _sources(items: int, size: int, seat: int) -> Ints:
    """For each of the D numbers that `seat` sees, where it stands in the row of `Encoder._row`."""
    bodies = 2 + items
    velocities = 3 * bodies
    cosines = velocities + 6
    sines = cosines + bodies
    holding = sines + bodies
    sources = np.arange(size) + holding + 2
    for slot, robot in enumerate((seat, 1 - seat)):
        pose = [3 * robot, 3 * robot + 1, cosines + robot, sines + robot]
        velocity = [velocities + 3 * robot + axis for axis in range(3)]
        sources[slot * ROBOT_WIDTH : (slot + 1) * ROBOT_WIDTH] = [*pose, holding + robot, *velocity]
    for slot, body in enumerate(range(2, bodies)):
        start = _ITEMS_START + slot * ITEM_WIDTH
        sources[start : start + 4] = [3 * body, 3 * body + 1, cosines + body, sines + body]
    return sources


def _template(map_spec: MapSpec, layout: ObservationLayout) -> Floats:
    """A vector (D,) with everything of the map that does not move."""
    vector = np.zeros(layout.size)
    layout.slots.check(map_spec, layout.name)
    for index, item in enumerate(map_spec.items):
        start = _ITEMS_START + index * ITEM_WIDTH + 4
        vector[start + SHAPES.index(item.shape)] = 1.0
        vector[start + len(SHAPES) + SIZES.index(item.size)] = 1.0
    start = _ITEMS_START + ITEM_SLOTS * ITEM_WIDTH
    if layout.wall_slots:
        _write_rects(vector[start : start + 4 * layout.wall_slots], map_spec.walls)
        start += 4 * layout.wall_slots
    if layout.goal_slots:
        _write_rects(vector[start:], map_spec.goals)
    return vector


def _write_rects(target: Floats, rects: tuple[Rect, ...]) -> None:
    """Corner pairs into the first slots of a stretch of the vector."""
    for index, rect in enumerate(rects):
        target[4 * index : 4 * index + 4] = rect.left, rect.top, rect.right, rect.bottom
