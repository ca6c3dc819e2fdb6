"""The layout `relative-v1`: what is around a robot, in its own frame, without any absolute place.

Vectors are (ahead, left): components along the robot's own heading and to its left. A turned map therefore looks the
same, a mirrored one has the sideways numbers' signs exchanged (`relative_mirror`), and both seats see alike.

| index | `relative-v1` |
|---|---|
| 0-3 | own velocity ahead and left [u/s], its length, angular velocity [rad/s] |
| 4 | own hand: +1 holds, -1 free |
| 5-7 | ln(1 + mass) / 4 of what is held, cos and sin of four times the own angle (how the walls lie) |
| 8-9 | partner minus own position, |
| 10-11 | the partner's heading, |
| 12 | its hand, +1 or -1, |
| 13-15 | its velocity [u/s] and angular velocity [rad/s], |
| 16-19 | way to it: unit vector, length / 4, straight or not |
| 20-35 | distance to the next wall or side in 16 directions from the own centre, counter-clockwise from ahead [u] |
| 36-51 | the same from what is held, or from the own grasp point |
| 52 + 11 k | goal region k (k = 0-3), the nearest first: 1 when it exists, |
| + 1-4 | way to it: unit vector, length / 4, straight or not, |
| + 5-6 | its centre minus own position, |
| + 7-9 | half width and height along the arena's axes: sum, and difference times cos, sin of twice the angle, |
| + 10 | share of its area that delivered items fill |
| 96 + 41 i | item i (i = 0-6): 1 when it exists, delivered, held by oneself, held by the partner, |
| + 4-14 | shape one-hot (8), size one-hot (3), |
| + 15-16 | scale, ln(1 + mass) / 4, |
| + 17-20 | item minus own position; cos and sin of its angle minus the own one, |
| + 21-24 | way from oneself: unit vector, length / 4, straight or not, |
| + 25-28 | way on to its nearest goal region: unit vector, length / 4, straight or not, |
| + 29 | distance from the own grasp point to the circle of the item's outline [u], |
| + 30-33 | way from the partner: unit vector, length / 4, straight or not, |
| + 34 | distance from the partner's grasp point to that circle [u], |
| + 35-36 | partner minus item, |
| + 37-38 | how well the partner's heading, and its velocity [u/s], point along its way to the item, |
| + 39-40 | the same of the own heading and velocity |
"""

import math

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec
from movingout.maps.spec import SHAPES, SIZES
from movingout.world import constants as c
from movingout.world.observation.array_encoder import ArrayEncoder
from movingout.world.observation.slots import Slots
from movingout.world.observation.ways import FAR, Seen, Ways, way_finder
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats, Ints

RELATIVE_LAYOUT = "relative-v1"
RAYS = 16
_ITEM_SLOTS, _GOAL_SLOTS = 7, 4
RELATIVE_SLOTS = Slots(items=_ITEM_SLOTS, goals=_GOAL_SLOTS)
_BODY, _GOAL, _ITEM = 20, 11, 41
_GOALS_START = _BODY + 2 * RAYS
_ITEMS_START = _GOALS_START + _GOAL_SLOTS * _GOAL
RELATIVE_SIZE = _ITEMS_START + _ITEM_SLOTS * _ITEM
_LENGTH = 4.0  # [u] brings way lengths to about 1
_LARGEST = 10.0

RELATIVE_ITEMS = tuple(
    tuple(range(_ITEMS_START + slot * _ITEM, _ITEMS_START + (slot + 1) * _ITEM)) for slot in range(_ITEM_SLOTS)
)
"""Indices (7, 41) of each item's numbers."""

OWN_NUMBERS = 8  # the first ones; the next 8 are the partner's
OWN_HAND, PARTNER_HEADING, PARTNER_HAND = 4, (10, 11), 12  # indices
_SIDEWAYS = [1, 3, 7, 9, 11, 14, 15, 17]  # what changes sign in a mirror
_SIDEWAYS_OF_GOAL = [2, 6, 9]
_SIDEWAYS_OF_ITEM = [18, 20, 22, 26, 31, 36]


def relative_mirror() -> tuple[Ints, Floats]:
    """Where each number of a mirrored observation comes from (D,), and its sign (D,)."""
    order, signs = np.arange(RELATIVE_SIZE), np.ones(RELATIVE_SIZE)
    for start in (_BODY, _BODY + RAYS):
        order[start : start + RAYS] = start + (-np.arange(RAYS)) % RAYS
    signs[_SIDEWAYS] = -1.0
    for slot in range(_GOAL_SLOTS):
        signs[_GOALS_START + slot * _GOAL + np.array(_SIDEWAYS_OF_GOAL)] = -1.0
    for slot in range(_ITEM_SLOTS):
        signs[_ITEMS_START + slot * _ITEM + np.array(_SIDEWAYS_OF_ITEM)] = -1.0
    return order, signs


def relative_bounds() -> Floats:
    """(D,) how large each number can be, up or down."""
    place, way, speed, spin = 4.8, [1.0, 1.0, FAR / _LENGTH, 1.0], 100.0, 1000.0
    body = [
        speed,
        speed,
        2 * speed,
        spin,
        1.0,
        _LARGEST,
        1.0,
        1.0,
        place,
        place,
        1.0,
        1.0,
        1.0,
        speed,
        speed,
        spin,
        *way,
    ]
    goal = [1.0, *way, place, place, place, place, place, _LARGEST]
    item = [1.0] * 15 + [place, _LARGEST, place, place, 1.0, 1.0, *way, *way, 2 * place, *way, 2 * place, place, place]
    item += [1.0, 2 * speed, 1.0, 2 * speed]
    return np.array([*body, *[place] * (2 * RAYS), *_GOAL_SLOTS * goal, *_ITEM_SLOTS * item])


class Frame:
    """The own frames (T,) of a seat: turns world vectors into (ahead, left)."""

    def __init__(self, angles: Floats) -> None:
        """`angles` (T,) of the robot."""
        self.cos, self.sin = np.cos(angles), np.sin(angles)

    def __call__(self, vectors: Floats) -> Floats:
        """(T, ..., 2) world vectors as (ahead, left)."""
        shape = (-1, *[1] * (vectors.ndim - 2))
        cos, sin = self.cos.reshape(shape), self.sin.reshape(shape)
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack((cos * y - sin * x, -cos * x - sin * y), axis=-1)


class RelativeEncoder(ArrayEncoder):
    """Encodes states of one map in `relative-v1`."""

    def __init__(self, map_spec: MapSpec) -> None:
        """Raises WorldError for a map that does not fit into the layout."""
        RELATIVE_SLOTS.check(map_spec, RELATIVE_LAYOUT)
        self.map = map_spec
        self._ways = way_finder(map_spec)
        kinds = [_kind(item.shape, item.size, item.scale, item.mass) for item in map_spec.items]
        self._constant = np.array(kinds).reshape(-1, 2 + len(SHAPES) + len(SIZES))
        self._scales = np.array([item.scale for item in map_spec.items])
        self._bulk = np.array([math.log1p(item.mass) for item in map_spec.items]) / 4
        sides = np.array([(g.right - g.left, g.top - g.bottom) for g in map_spec.goals]) / 2
        self._halves = sides
        self._centres = np.array([((g.left + g.right) / 2, (g.bottom + g.top) / 2) for g in map_spec.goals])

    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> Floats:
        """The vectors (T, D) of states given as arrays: (T, 2, 3), (T, 2, 3), (T, 2) and (T, N, 3)."""
        view = _View(self, robot_poses, robot_velocities, held, item_poses, seat)
        parts = view.bodies(), view.rays(), view.goals(), view.items()
        rows: Floats = np.concatenate([part.reshape(len(robot_poses), -1) for part in parts], axis=1)
        return rows


class _View:
    """What one seat sees in T states of a map."""

    def __init__(
        self, own: RelativeEncoder, robot_poses: Floats, velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> None:
        self.map, self.finder, self.of = own.map, own._ways, own
        order = [seat, 1 - seat]
        self.poses, self.speeds, self.held = robot_poses[:, order], velocities[:, order], held[:, order]
        self.items_at = item_poses
        self.frame = Frame(self.poses[:, 0, 2])
        angles = self.poses[..., 2]
        self.headings = np.stack((-np.sin(angles), np.cos(angles)), axis=-1)  # (T, 2, 2)
        self.grasps = self.poses[..., :2] + c.REACH * self.headings
        points = np.concatenate((self.poses[..., :2], item_poses[..., :2]), axis=1)
        seen = self.finder.seen(points)
        self.own, self.partner, self.things = (_part(seen, part) for part in (slice(0, 1), slice(1, 2), slice(2, None)))
        self.delivered = delivered_many(own.map, item_poses)

    def bodies(self) -> Floats:
        """(T, 20) the two robots."""
        angle = self.poses[:, 0, 2]
        velocity = self.frame(self.speeds[..., :2])
        apart = self.frame(self.poses[:, 1, :2] - self.poses[:, 0, :2])
        hands = np.where(self.held >= 0, 1.0, -1.0)
        load = np.append(self.of._bulk, 0.0)[self.held[:, 0]]  # -1, a free hand, is the last one
        way = self._way(self.finder.between(self.own, self.partner))[:, 0]
        numbers = [
            velocity[:, 0], np.linalg.norm(velocity[:, 0], axis=-1), self.speeds[:, 0, 2], hands[:, 0], load,
            np.cos(4 * angle), np.sin(4 * angle),
            apart, self.frame(self.headings[:, 1]), hands[:, 1], velocity[:, 1], self.speeds[:, 1, 2], way,
        ]  # fmt: skip
        return np.concatenate([part if part.ndim == 2 else part[:, None] for part in numbers], axis=1)

    def rays(self) -> Floats:
        """(T, 32) distances to walls."""
        turns = self.poses[:, 0, 2, None] + np.arange(RAYS) * (2 * np.pi / RAYS)
        directions = np.stack((-np.sin(turns), np.cos(turns)), axis=-1)
        places = np.concatenate((self.items_at[..., :2], self.grasps[:, :1]), axis=1)
        load = places[np.arange(len(places)), self.held[:, 0]]  # -1, a free hand, is the grasp point
        return np.concatenate(
            (self.finder.rays(self.poses[:, 0, :2], directions), self.finder.rays(load, directions)), axis=1
        )

    def goals(self) -> Floats:
        """(T, 4, 11) the goal regions, the nearest first."""
        ticks, count = len(self.poses), len(self.map.goals)
        ways = self.finder.to_goals(self.own)
        centres = self.of._centres
        half, angle = self.of._halves, self.poses[:, 0, 2, None]
        inside = (np.abs(self.items_at[:, None, :, :2] - centres[:, None]) <= half[:, None] + 0.05).all(axis=-1)
        filled = (inside * self.delivered[:, None]) @ (np.pi * self.of._scales**2) / (4 * half.prod(axis=-1))
        numbers = [
            np.ones((ticks, count, 1)),
            self._way(Ways(ways.directions[:, 0], ways.lengths[:, 0], ways.straight[:, 0])),
            self.frame(centres - self.poses[:, :1, :2]),
            np.broadcast_to(half.sum(axis=-1)[:, None], (ticks, count, 1)),
            ((half[:, 0] - half[:, 1]) * np.cos(2 * angle))[..., None],
            ((half[:, 0] - half[:, 1]) * np.sin(2 * angle))[..., None],
            filled[..., None],
        ]
        slots = np.zeros((ticks, _GOAL_SLOTS, _GOAL))
        order = np.argsort(ways.lengths[:, 0], axis=-1, kind="stable")
        slots[:, :count] = np.take_along_axis(np.concatenate(numbers, axis=-1), order[..., None], axis=1)
        return slots

    def items(self) -> Floats:
        """(T, 7, 41) the items."""
        ticks, count = self.items_at.shape[:2]
        places, index = self.items_at[..., :2], np.arange(count)
        ways, partners = self.finder.between(self.own, self.things), self.finder.between(self.partner, self.things)
        angles = self.items_at[..., 2] - self.poses[:, :1, 2]
        flags = np.ones((ticks, count)), self.delivered, self.held[:, :1] == index, self.held[:, 1:] == index
        numbers = [
            np.stack(flags, axis=-1),
            np.broadcast_to(self.of._constant, (ticks, *self.of._constant.shape)),
            self.frame(places - self.poses[:, :1, :2]),
            np.stack((np.cos(angles), np.sin(angles)), axis=-1),
            self._way(ways),
            self._way(self._home()),
            self._gap(0),
            self._way(partners),
            self._gap(1),
            self.frame(self.poses[:, 1:, :2] - places),
            self._aim(1, partners),
            self._aim(0, ways),
        ]
        slots = np.zeros((ticks, _ITEM_SLOTS, _ITEM))
        slots[:, :count] = np.concatenate(numbers, axis=-1)
        return slots

    def _home(self) -> Ways:
        """The ways from the items to the goal region that is nearest by way."""
        ways = self.finder.to_goals(self.things)
        nearest = ways.lengths.argmin(axis=-1)[..., None]
        return Ways(
            np.take_along_axis(ways.directions, nearest[..., None], axis=2)[:, :, 0],
            np.take_along_axis(ways.lengths, nearest, axis=2)[..., 0],
            np.take_along_axis(ways.straight, nearest, axis=2)[..., 0],
        )

    def _gap(self, robot: int) -> Floats:
        """(T, N, 1) from a robot's grasp point to the circle of each item's outline."""
        apart = np.linalg.norm(self.items_at[..., :2] - self.grasps[:, robot, None], axis=-1)
        gaps: Floats = (apart - self.of._scales)[..., None]
        return gaps

    def _aim(self, robot: int, ways: Ways) -> Floats:
        """(T, N, 2) a robot's heading and velocity along its ways to the items."""
        heading = (self.headings[:, robot, None] * ways.directions).sum(axis=-1)
        velocity = (self.speeds[:, robot, None, :2] * ways.directions).sum(axis=-1)
        return np.stack((heading, velocity), axis=-1)

    def _way(self, ways: Ways) -> Floats:
        """(T, P, 4) ways as numbers."""
        length = ways.lengths / _LENGTH
        return np.concatenate(
            (self.frame(ways.directions), length[..., None], ways.straight[..., None].astype(np.float64)), axis=-1
        )


def _part(seen: Seen, part: slice) -> Seen:
    return Seen(seen.points[:, part], seen.corners[:, part])


def _kind(shape: str, size: str, scale: float, mass: float) -> npt.NDArray[np.float64]:
    """(13,) what never changes of an item."""
    shapes = [float(shape == each) for each in SHAPES]
    sizes = [float(size == each) for each in SIZES]
    return np.array([*shapes, *sizes, scale, math.log1p(mass) / 4])
