"""Which items are delivered, and the score: functions of a map and of poses alone.

An item is delivered when one goal, with its margin of 0.05, contains the item's bounding box in
its current pose; being held does not matter, and lying across two regions does not count (official rule).
"""

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from movingout.maps.shapes import corner_radius, outline
from movingout.maps.spec import GOAL_MARGIN, ItemSpec, MapSpec
from movingout.world.state import Floats

Box = tuple[float, float, float, float]  # left, bottom, right, top


def delivered_items(map_spec: MapSpec, item_poses: Floats) -> npt.NDArray[np.bool_]:
    """(N,) whether each item is delivered, for poses (N, 3) of x, y, angle."""
    goals = goal_boxes(map_spec)
    rows = item_poses.tolist()
    flags = [is_delivered(item, row, goals) for item, row in zip(map_spec.items, rows, strict=True)]
    return np.array(flags, dtype=np.bool_)


def delivered_many(map_spec: MapSpec, item_poses: Floats) -> npt.NDArray[np.bool_]:
    """(T, N) the same for poses (T, N, 3) of many moments; only items with their centre in a goal are looked at."""
    goals = goal_boxes(map_spec)
    flags = np.zeros(item_poses.shape[:2], dtype=np.bool_)
    x, y = item_poses[..., 0], item_poses[..., 1]
    near = np.zeros_like(flags)
    for left, bottom, right, top in goals:
        near |= (left <= x) & (x <= right) & (bottom <= y) & (y <= top)
    known: dict[tuple[float, ...], bool] = {}  # most items lie where they lay the moment before
    for (moment, item), pose in zip(np.argwhere(near).tolist(), item_poses[near].tolist(), strict=True):
        key = item, *pose
        if key not in known:
            known[key] = is_delivered(map_spec.items[item], tuple(pose), goals)
        flags[moment, item] = known[key]
    return flags


def is_delivered(item: ItemSpec, pose: tuple[float, ...], goals: tuple[Box, ...]) -> bool:
    """Whether one item in one pose (x, y, angle) lies within one of the goal boxes."""
    x, y, _ = pose
    around = [g for g in goals if g[0] <= x <= g[2] and g[1] <= y <= g[3]]  # what holds the box holds its centre
    if not around:
        return False
    left, bottom, right, top = bounding_box(item, pose)
    return any(g[0] <= left and g[1] <= bottom and g[2] >= right and g[3] >= top for g in around)


def bounding_box(item: ItemSpec, pose: tuple[float, ...]) -> Box:
    """The item's axis-aligned box in a pose (x, y, angle), rounded as the engine rounds it."""
    x, y, angle = pose
    if item.shape == "circle":
        return x - item.scale, y - item.scale, x + item.scale, y + item.scale
    cos, sin = math.cos(angle), math.sin(angle)
    vertices = outline(item.shape, item.scale)
    xs = [cos * vx + -sin * vy + x for vx, vy in vertices]
    ys = [sin * vx + cos * vy + y for vx, vy in vertices]
    radius = corner_radius(item.shape, item.scale)
    return min(xs) - radius, min(ys) - radius, max(xs) + radius, max(ys) + radius


@lru_cache(maxsize=256)
def goal_boxes(map_spec: MapSpec) -> tuple[Box, ...]:
    """The goals with their margin, as the engine holds them (centre and half sizes)."""
    boxes = []
    for goal in map_spec.goals:
        x, y = (goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2
        half_width = (goal.right - goal.left + 2 * GOAL_MARGIN) / 2
        half_height = (goal.top - goal.bottom + 2 * GOAL_MARGIN) / 2
        boxes.append((x - half_width, y - half_height, x + half_width, y + half_height))
    return tuple(boxes)
