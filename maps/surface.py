"""Distance of a point from an item's surface, in the item's own frame."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from movingout.maps.shapes import corner_radius, outline
from movingout.maps.spec import Shape

Floats = npt.NDArray[np.float64]


def surface_distance(shape: Shape, scale: float, points: Floats) -> Floats:
    """(M,) signed distances of points (M, 2) in the item's frame to its surface, negative inside; arena units."""
    if shape == "circle":
        return np.asarray(np.hypot(points[:, 0], points[:, 1]) - scale)
    starts, edges = polygon(shape, scale)
    relative = points[:, None, :] - starts
    along = np.clip((relative * edges).sum(-1) / (edges * edges).sum(-1), 0.0, 1.0)
    gaps = relative - along[..., None] * edges
    distance = np.sqrt((gaps * gaps).sum(-1)).min(axis=1)
    return np.asarray(np.where(_inside(starts, edges, points), -distance, distance) - corner_radius(shape, scale))


@lru_cache(maxsize=1024)
def polygon(shape: Shape, scale: float) -> tuple[Floats, Floats]:
    """The vertices (V, 2) of an outline and the edges (V, 2) that begin there."""
    vertices = np.array(outline(shape, scale))
    return vertices, np.roll(vertices, -1, axis=0) - vertices


def _inside(starts: Floats, edges: Floats, points: Floats) -> npt.NDArray[np.bool_]:
    """Whether each point lies inside the polygon, by counting crossings of the ray to +x."""
    px, py = points[:, 0, None], points[:, 1, None]
    y0, y1 = starts[:, 1], starts[:, 1] + edges[:, 1]
    spans = (y0 > py) != (y1 > py)
    slope = np.divide(edges[:, 0], edges[:, 1], out=np.zeros_like(edges[:, 0]), where=edges[:, 1] != 0)
    return np.asarray((spans & (px < starts[:, 0] + (py - y0) * slope)).sum(axis=1) % 2 == 1)
