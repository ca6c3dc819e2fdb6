"""Shapes as a planner needs them: distances to an item's surface, its reach in a direction, discs that cover it."""

import math
from functools import lru_cache

import numpy as np

from maps import ItemSpec
from maps.shapes import circumradius, corner_radius, outline
from world.state import Floats

Disc = tuple[float, float, float]  # x, y, radius in a body's own frame


def wrap(angle: float) -> float:
    """The angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def heading_of(dx: float, dy: float) -> float:
    """The heading (0 along +y, counter-clockwise) that looks along (dx, dy)."""
    return math.atan2(-dx, dy)


def forward(angle: float) -> tuple[float, float]:
    """The unit vector along a heading."""
    return -math.sin(angle), math.cos(angle)


def signed_distance(item: ItemSpec, pose: Floats, points: Floats) -> Floats:
    """(M,) distance of points (M, 2) to the item's surface in pose (3,), negative inside."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    local = (points - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])
    if item.shape == "circle":
        return np.asarray(np.hypot(local[:, 0], local[:, 1]) - item.scale)
    starts, edges = _edges(item)
    relative = local[:, None, :] - starts
    along = np.clip((relative * edges).sum(-1) / (edges * edges).sum(-1), 0.0, 1.0)
    gaps = relative - along[..., None] * edges
    distance = np.sqrt((gaps * gaps).sum(-1)).min(axis=1)
    return np.asarray(
        np.where(_inside(starts, edges, local), -distance, distance) - corner_radius(item.shape, item.scale)
    )


def half_extents(item: ItemSpec, angle: float) -> tuple[float, float]:
    """Half width and half height of the item's bounding box at an angle (the larger side where it is lopsided)."""
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
    """Discs that stand for the item in collision checks: round shapes one, pointed ones their core and their tips."""
    radius = circumradius(item.shape, item.scale) + corner_radius(item.shape, item.scale)
    if item.size == "small" or item.shape in ("circle", "hexagon", "octagon", "pentagon"):
        return ((0.0, 0.0, radius),)
    starts, edges = _edges(item)
    middles = starts + edges / 2
    core = float(np.hypot(middles[:, 0], middles[:, 1]).min())
    tips = tuple((float(x) * 0.93, float(y) * 0.93, 0.07 * radius) for x, y in starts)
    return ((0.0, 0.0, core), *tips)


@lru_cache(maxsize=1024)
def _edges(item: ItemSpec) -> tuple[Floats, Floats]:
    vertices = np.array(outline(item.shape, item.scale))
    return vertices, np.roll(vertices, -1, axis=0) - vertices


def _inside(starts: Floats, edges: Floats, points: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether each point lies inside the polygon, by counting crossings of the ray to +x."""
    px, py = points[:, 0, None], points[:, 1, None]
    y0, y1 = starts[:, 1], starts[:, 1] + edges[:, 1]
    spans = (y0 > py) != (y1 > py)
    slope = np.divide(edges[:, 0], edges[:, 1], out=np.zeros_like(edges[:, 0]), where=edges[:, 1] != 0)
    return np.asarray((spans & (px < starts[:, 0] + (py - y0) * slope)).sum(axis=1) % 2 == 1)
