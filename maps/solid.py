"""Solids on a map as convex or star-shaped outlines with a rounding radius, and the gap between two of them."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from movingout.maps.shapes import corner_radius, outline
from movingout.maps.spec import ARENA_HALF, ROBOT_RADIUS, WALL_MARGIN, ItemSpec, Pose, Rect

_FAR = 0.1

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A simple polygon (n, 2), or a single point (1, 2), grown by `radius` on every side."""

    points: Points
    radius: float

    @cached_property
    def box(self) -> Rect:
        """The axis-aligned bounding box."""
        (left, bottom), (right, top) = self.points.min(axis=0) - self.radius, self.points.max(axis=0) + self.radius
        return Rect(float(left), float(bottom), float(right), float(top))

    def gap(self, other: "Solid") -> float:
        """The distance between the surfaces; negative when they overlap, without saying by how much.

        Beyond 0.1 it is only a lower bound.
        """
        apart = max(
            self.box.left - other.box.right,
            other.box.left - self.box.right,
            self.box.bottom - other.box.top,
            other.box.bottom - self.box.top,
        )
        if apart > _FAR:
            return apart
        if _overlap(self.points, other.points):
            return -math.inf
        distance = min(_to_edges(self.points, other.points).min(), _to_edges(other.points, self.points).min())
        return float(distance) - self.radius - other.radius

    def distances_from(self, points: Points) -> Points:
        """Distances (P,) from points (P, 2) to the surface; negative inside the rounding, not inside the polygon."""
        if len(self.points) == 1:
            distances = np.hypot(*(points - self.points[0]).T)
        else:
            distances = _to_edges(points, self.points).min(axis=1)
        return np.asarray(distances - self.radius)


def item_solid(item: ItemSpec) -> Solid:
    """An item where it stands."""
    pose = item.pose
    if item.shape == "circle":
        return Solid(np.array([(pose.x, pose.y)]), item.scale)
    cos, sin = math.cos(pose.angle), math.sin(pose.angle)
    turned = np.array(outline(item.shape, item.scale)) @ np.array([(cos, sin), (-sin, cos)])
    return Solid(turned + np.array([(pose.x, pose.y)]), corner_radius(item.shape, item.scale))


def robot_solid(pose: Pose) -> Solid:
    """A robot where it stands."""
    return Solid(np.array([(pose.x, pose.y)]), ROBOT_RADIUS)


def wall_solid(wall: Rect) -> Solid:
    """A wall, filled."""
    corners = [(wall.left, wall.bottom), (wall.right, wall.bottom), (wall.right, wall.top), (wall.left, wall.top)]
    return Solid(np.array(corners), WALL_MARGIN)


def beyond_arena(solid: Solid) -> float:
    """By how much a solid sticks out of the arena; negative is the room that is left."""
    box = solid.box
    return max(-ARENA_HALF - box.left, -ARENA_HALF - box.bottom, box.right - ARENA_HALF, box.top - ARENA_HALF)


def _to_edges(points: Points, polygon: Points) -> Points:
    """(P, n) distances from points to the edges of a polygon (one point has one edge of no length)."""
    starts, ends = polygon, np.roll(polygon, -1, axis=0)
    edges = ends - starts  # (n, 2)
    offsets = points[:, None] - starts  # (P, n, 2)
    lengths = np.maximum((edges**2).sum(axis=1), 1e-30)
    along = np.clip((offsets * edges).sum(axis=2) / lengths, 0.0, 1.0)
    away = offsets - along[..., None] * edges
    return np.asarray(np.hypot(away[..., 0], away[..., 1]))


def _overlap(a: Points, b: Points) -> bool:
    """Whether two polygons cross or one contains the other (or a point)."""
    return bool(_contains(a, b[0]) or _contains(b, a[0]) or _cross(a, b))


def _contains(polygon: Points, point: Points) -> bool:
    """Whether a point is inside a simple polygon: an odd number of edges to its right."""
    if len(polygon) < 3:
        return False
    (x, y), starts, ends = point, polygon, np.roll(polygon, -1, axis=0)
    straddles = (starts[:, 1] > y) != (ends[:, 1] > y)
    rise = np.where(straddles, ends[:, 1] - starts[:, 1], 1.0)
    crossings = starts[:, 0] + (y - starts[:, 1]) * (ends[:, 0] - starts[:, 0]) / rise
    return bool((straddles & (crossings > x)).sum() % 2)


def _cross(a: Points, b: Points) -> bool:
    """Whether any edge of one polygon crosses an edge of the other."""
    a0, a1 = a[:, None], np.roll(a, -1, axis=0)[:, None]
    b0, b1 = b[None], np.roll(b, -1, axis=0)[None]
    return bool((((_side(a0, a1, b0) * _side(a0, a1, b1)) < 0) & ((_side(b0, b1, a0) * _side(b0, b1, a1)) < 0)).any())


def _side(start: Points, end: Points, point: Points) -> Points:
    """Positive where a point is left of the line from start to end."""
    along, to = end - start, point - start
    return np.asarray(along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0])
