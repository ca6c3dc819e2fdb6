"""The input of the learned simulator: the moving and the constant part of the state, in seat order.

The order is blue, red instead of own, other, because a tick is not symmetric: blue's action takes effect first.

| moving (58) | |
|---|---|
| 0-13 | blue and red: x, y, cos, sin of the angle, vx, vy [units/s], angular velocity / 5 |
| 14-29 | blue and red: what is held, one-hot over 7 items, and 1 for an empty hand |
| 30-57 | 7 items: x, y, cos, sin of the angle |

| constant (146) | |
|---|---|
| 0-97 | 7 items: 1 when it exists, shape (8), size (3), scale, ln(1 + mass) / 4 |
| 98-145 | 8 walls and 4 goals: left, top, right, bottom |
"""

import math
from functools import lru_cache

import numpy as np

from movingout.agents.observation.seat_observation import start_state
from movingout.maps import MapSpec
from movingout.maps.spec import SHAPES, SIZES
from movingout.world.observation import ITEM_SLOTS, encode_state
from movingout.world.state import Floats, Ints, WorldState

ROBOT_WIDTH = 7
HELD_START = 2 * ROBOT_WIDTH
HELD_WIDTH = ITEM_SLOTS + 1
ITEMS_START = HELD_START + 2 * HELD_WIDTH
MOVING_WIDTH = ITEMS_START + 4 * ITEM_SLOTS
ITEM_CONSTANTS = 3 + len(SHAPES) + len(SIZES)
_MAP_RECTANGLES = 48  # the last numbers of layout map-v1
CONSTANT_WIDTH = ITEM_SLOTS * ITEM_CONSTANTS + _MAP_RECTANGLES
ACTION_WIDTH = 4  # distance, cos, sin, and the desired hold level or the toggle
TURN_UNIT = 5.0  # [rad/s], the fastest turn


def moving(state: WorldState) -> Floats:
    """The moving part (58,) of one state."""
    arrays = state.robot_poses[None], state.robot_velocities[None], state.held[None], state.item_poses[None]
    row: Floats = moving_arrays(*arrays)[0]
    return row


def moving_arrays(robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats) -> Floats:
    """The moving part (T, 58) of states given as arrays (T, 2, 3), (T, 2, 3), (T, 2) and (T, N, 3)."""
    ticks, count = item_poses.shape[:2]
    robots = np.concatenate(
        (
            robot_poses[..., :2],
            np.cos(robot_poses[..., 2:]),
            np.sin(robot_poses[..., 2:]),
            robot_velocities[..., :2],
            robot_velocities[..., 2:] / TURN_UNIT,
        ),
        axis=-1,
    )
    hands = np.eye(HELD_WIDTH)[np.where(held < 0, ITEM_SLOTS, held)]
    items = np.zeros((ticks, ITEM_SLOTS, 4))
    items[:, :count, :2] = item_poses[..., :2]
    items[:, :count, 2] = np.cos(item_poses[..., 2])
    items[:, :count, 3] = np.sin(item_poses[..., 2])
    return np.concatenate([part.reshape(ticks, -1) for part in (robots, hands, items)], axis=1)


def states_of(rows: Floats, count: int) -> tuple[Floats, Floats, Ints, Floats]:
    """The inverse of `moving_arrays`, for a map of `count` items: poses, velocities, held, item poses."""
    robots = rows[:, :HELD_START].reshape(-1, 2, ROBOT_WIDTH)
    items = rows[:, ITEMS_START:].reshape(-1, ITEM_SLOTS, 4)[:, :count]
    velocities = robots[..., 4:] * (1.0, 1.0, TURN_UNIT)
    return _poses(robots), velocities, held_of(rows), _poses(items)


def held_of(rows: Floats) -> Ints:
    """Held items (T, 2) of blue and red in moving rows (T, 58), -1 for an empty hand."""
    held = rows[:, HELD_START:ITEMS_START].reshape(-1, 2, HELD_WIDTH).argmax(axis=-1)
    return np.where(held == ITEM_SLOTS, -1, held)


def _poses(rows: Floats) -> Floats:
    """x, y, cos, sin, ... to x, y, angle."""
    return np.concatenate((rows[..., :2], np.arctan2(rows[..., 3:4], rows[..., 2:3])), axis=-1)


def item_places(rows: Floats, count: int) -> Floats:
    """x, y (..., N, 2) of the first `count` items in moving rows (..., 58)."""
    items = rows[..., ITEMS_START:].reshape(*rows.shape[:-1], ITEM_SLOTS, 4)
    places: Floats = items[..., :count, :2]
    return places


def robot_places(rows: Floats) -> Floats:
    """x, y (..., 2, 2) of blue and red in moving rows (..., 58)."""
    robots = rows[..., :HELD_START].reshape(*rows.shape[:-1], 2, ROBOT_WIDTH)
    places: Floats = robots[..., :2]
    return places


@lru_cache(maxsize=64)
def constant(map_spec: MapSpec) -> Floats:
    """The constant part (146,) of a map."""
    items = np.zeros((ITEM_SLOTS, ITEM_CONSTANTS))
    for index, item in enumerate(map_spec.items):
        items[index, 0] = 1.0
        items[index, 1 + SHAPES.index(item.shape)] = 1.0
        items[index, 1 + len(SHAPES) + SIZES.index(item.size)] = 1.0
        items[index, -2:] = item.scale, math.log1p(item.mass) / 4
    rectangles = encode_state(map_spec, start_state(map_spec), 0, "map-v1")[-_MAP_RECTANGLES:]
    row = np.concatenate((items.ravel(), rectangles))
    row.setflags(write=False)
    return row
