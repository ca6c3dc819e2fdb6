"""The layout `aware-v1`, what the `@all` agents see: `map-v1` and relations that a small network cannot work out.

These are the ways around walls and who holds what, so that one policy can play all maps.

| index | `aware-v1` |
|---|---|
| 0-168 | `map-v1` |
| 169-170 | partner minus own position |
| 171-172 | unit vector of the way to the partner, around walls |
| 173 + 15 i | item i (i = 0-6): 1 when it exists, delivered, held by oneself, held by the partner, |
| + 4-5 | item minus own position, |
| + 6-7 | unit vector of the way from oneself to the item, + 8 its length / 4, |
| + 9-10 | unit vector of the way from the item to its nearest goal, + 11 its length / 4, |
| + 12 | distance from one's grasp point to the item's outline's circle [u], |
| + 13-14 | scale, and ln(1 + mass) / 4 |
"""

import math

import numpy as np

from movingout.maps import MapSpec
from movingout.world import constants as c
from movingout.world.observation.array_encoder import ArrayEncoder
from movingout.world.observation.egocentric import (
    ITEM_SLOTS,
    ITEM_WIDTH,
    POSITION,
    ROBOT_WIDTH,
    WITH_MAP,
    Encoder,
)
from movingout.world.observation.navigation import FAR, navigation, on_grid
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats, Ints

AWARE_LAYOUT = "aware-v1"
_ITEM_WIDTH = 15
_PARTNER_WIDTH = 4
_BODIES = 2 * ROBOT_WIDTH  # where the first item's numbers begin in the official layout
PARTNER_OFFSET = WITH_MAP.size  # where partner minus own position begins
_RELATIONS = PARTNER_OFFSET + _PARTNER_WIDTH  # and in ours
_LARGEST_BULK = 10.0  # of ln(1 + mass) / 4
_LENGTH_UNIT = 4.0  # [u] brings way lengths to about 1
AWARE_SIZE = _RELATIONS + ITEM_SLOTS * _ITEM_WIDTH

ITEM_COLUMNS = tuple(
    (
        *range(_BODIES + slot * ITEM_WIDTH, _BODIES + (slot + 1) * ITEM_WIDTH),
        *range(_RELATIONS + slot * _ITEM_WIDTH, _RELATIONS + (slot + 1) * _ITEM_WIDTH),
    )
    for slot in range(ITEM_SLOTS)
)
"""Indices (7, 30) of each item's numbers in `aware-v1`."""


def aware_bounds() -> Floats:
    """(D,) how large each number can be, up or down."""
    apart, way = 2 * POSITION, FAR / _LENGTH_UNIT
    item = [1.0] * 4 + [apart] * 2 + [1.0, 1.0, way] * 2 + [2 * apart, POSITION, _LARGEST_BULK]
    return np.concatenate((WITH_MAP.bounds, [apart, apart, 1.0, 1.0], ITEM_SLOTS * item))


class AwareEncoder(ArrayEncoder):
    """Encodes states of one map in `aware-v1`."""

    def __init__(self, map_spec: MapSpec) -> None:
        """Raises WorldError for a map that does not fit into the layout."""
        WITH_MAP.slots.check(map_spec, AWARE_LAYOUT)
        self.map = map_spec
        self._base = Encoder(map_spec, WITH_MAP)
        self._bulk = np.array([[item.scale, math.log1p(item.mass) / 4] for item in map_spec.items]).reshape(-1, 2)

    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> Floats:
        """The vectors (T, D) of states given as arrays: (T, 2, 3), (T, 2, 3), (T, 2) and (T, N, 3)."""
        base = self._base.encode_arrays(robot_poses, robot_velocities, held, item_poses, seat)
        partner, items = self._relations(robot_poses, held, item_poses, seat)
        ticks, count = items.shape[:2]
        slots = np.zeros((ticks, ITEM_SLOTS, _ITEM_WIDTH))
        slots[:, :count] = items
        return np.concatenate((base, partner, slots.reshape(ticks, -1)), axis=1)

    @staticmethod
    def delivered(rows: Floats) -> Floats:
        """Whether each item is delivered (B, 7), 1 or 0, in rows (B, D) of `aware-v1`."""
        items = rows[:, _RELATIONS:].reshape(-1, ITEM_SLOTS, _ITEM_WIDTH)
        flags: Floats = items[..., 1]
        return flags

    def _relations(self, robot_poses: Floats, held: Ints, item_poses: Floats, seat: int) -> tuple[Floats, Floats]:
        """The partner's (T, 4) and the items' (T, N, 15) numbers of `aware-v1`."""
        ways = navigation(self.map)
        own, other = robot_poses[:, seat, :2], robot_poses[:, 1 - seat, :2]
        places = item_poses[..., :2]
        here, there = on_grid(own[:, None]), on_grid(places)
        to_items, lengths = ways.ways(here, there)
        homewards, lengths_home = ways.ways(there, ways.nearest_goal(there))
        to_other, _ = ways.ways(here, on_grid(other[:, None]))
        angles = robot_poses[:, seat, 2]
        grasp = own + c.REACH * np.stack((-np.sin(angles), np.cos(angles)), axis=-1)
        index = np.arange(places.shape[1])
        numbers = [
            np.ones(places.shape[:2]),
            delivered_many(self.map, item_poses),
            held[:, seat, None] == index,
            held[:, 1 - seat, None] == index,
            places - own[:, None],
            to_items,
            lengths / _LENGTH_UNIT,
            homewards,
            lengths_home / _LENGTH_UNIT,
            np.linalg.norm(places - grasp[:, None], axis=-1) - self._bulk[:, 0],
            np.broadcast_to(self._bulk, (*places.shape[:2], 2)),
        ]
        columns = [part if part.ndim == 3 else part[..., None] for part in numbers]
        partner = np.concatenate((other - own, to_other[:, 0]), axis=1)
        return partner, np.concatenate(columns, axis=-1)
