"""Geometry for planning: distances to an item's surface, bounding boxes, and discs that cover an item."""

import math
from functools import lru_cache

import numpy as np

from movingout.maps import ItemSpec
from movingout.maps.shapes import circumradius, corner_radius, outline
from movingout.maps.surface import polygon, surface_distance
from movingout.world.state import Floats

Disc = tuple[float, float, float]  # x, y, radius in a body's own frame


def wrap(angle: float) -> float:
    """The angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def heading_of(dx: float, dy: float) -> float:
    """The heading (0 along +y, counter-clockwise) of the direction (dx, dy)."""
    return math.atan2(-dx, dy)


def forward(angle: float) -> tuple[float, float]:
    """The unit vector along a heading."""
    return -math.sin(angle), math.cos(angle)


def signed_distance(item: ItemSpec, pose: Floats, points: Floats) -> Floats:
    """(M,) distance of points (M, 2) to the item's surface in pose (3,), negative inside."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    local = (points - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])
    return surface_distance(item.shape, item.scale, local)


@lru_cache(maxsize=512)  # all grasps of an item use the same angles
def half_extents(item: ItemSpec, angle: float) -> tuple[float, float]:
    """Half width and half height of the item's bounding box at an angle (the larger side of an asymmetric shape)."""
    if item.shape == "circle":
        return item.scale, item.scale
    vertices = np.array(outline(item.shape, item.scale))
    cos, sin = math.cos(angle), math.sin(angle)
    xs = np.abs(vertices[:, 0] * cos - vertices[:, 1] * sin).max()
    ys = np.abs(vertices[:, 0] * sin + vertices[:, 1] * cos).max()
    radius = corner_radius(item.shape, item.scale)
    return float(xs) + radius, float(ys) + radius


@lru_cache(maxsize=256)
def covering_discs(item: ItemSpec) -> tuple[Disc, ...]:
    """Discs that represent the item in collision checks: one for round shapes, core and corners for others."""
    radius = circumradius(item.shape, item.scale) + corner_radius(item.shape, item.scale)
    if item.size == "small" or item.shape in ("circle", "hexagon", "octagon", "pentagon"):
        return ((0.0, 0.0, radius),)
    starts, edges = polygon(item.shape, item.scale)
    middles = starts + edges / 2
    core = float(np.hypot(middles[:, 0], middles[:, 1]).min())
    tips = tuple((float(x) * 0.93, float(y) * 0.93, 0.07 * radius) for x, y in starts)
    return ((0.0, 0.0, core), *tips)
