"""The outlines of the eight item shapes: one source for the physics, the pictures and the scoring.

Every shape but the rectangle and the star has (about) the area of a circle of radius `scale`; the
triangle is drawn a fifth shorter. Source: the official environment.
Vertices are in the item's own frame at angle 0, counter-clockwise, in arena units; their exact float
arithmetic matters, because the physics is compared to the bit.
"""

import math
from functools import lru_cache

from movingout.maps.spec import Shape

Vertices = tuple[tuple[float, float], ...]

TRIANGLE_FACTOR = 0.8  # the official triangle's side is 0.8 of the area rule
STAR_OUTER, STAR_INNER = 1.3, 0.65  # radii of a star's tips and notches, in scales
CORNER_FRACTION = 0.01  # corner radius of boxes, in sides; it is added outside the box

_SIDES: dict[Shape, int] = {"triangle": 3, "pentagon": 5, "hexagon": 6, "octagon": 8}


@lru_cache(maxsize=1024)
def outline(shape: Shape, scale: float) -> Vertices:
    """The vertices of a shape. A circle has none: its radius is `scale`."""
    if shape == "circle":
        return ()
    if shape == "star":
        return _star(scale)
    if shape in ("square", "rectangle"):
        half_width, half_height = (side / 2 for side in box_sides(shape, scale))
        return (
            (half_width, -half_height),
            (half_width, half_height),
            (-half_width, half_height),
            (-half_width, -half_height),
        )
    return _regular(_SIDES[shape], scale)


def box_sides(shape: Shape, scale: float) -> tuple[float, float]:
    """Width and height of a square or of a rectangle (twice as wide as high)."""
    side = math.sqrt(math.pi) * scale
    return (side, side / 2) if shape == "rectangle" else (side, side)


def corner_radius(shape: Shape, scale: float) -> float:
    """By how much the solid shape exceeds its outline on every side; not 0 for boxes alone."""
    return CORNER_FRACTION * box_sides(shape, scale)[0] if shape in ("square", "rectangle") else 0.0


def circumradius(shape: Shape, scale: float) -> float:
    """Distance from the centre to the outermost point of the outline."""
    return max((math.hypot(x, y) for x, y in outline(shape, scale)), default=scale)


def _regular(sides: int, scale: float) -> Vertices:
    half_angle = math.pi / sides
    side = 2 * scale * math.sqrt(half_angle * math.tan(half_angle))
    if sides == 3:
        side *= TRIANGLE_FACTOR
    radius = side / (2 * math.sin(half_angle))
    step = 2 * math.pi / sides  # k * step, not 2 pi k / sides: they differ in the last bit
    return tuple((-radius * math.sin(k * step), radius * math.cos(k * step)) for k in range(sides))


def _star(scale: float) -> Vertices:
    vertices = []
    for k in range(5):
        tip = k * 2 * math.pi / 5
        for radius, angle in ((STAR_OUTER * scale, tip), (STAR_INNER * scale, tip + math.pi / 5)):
            vertices.append((-radius * math.sin(angle), radius * math.cos(angle)))
    return tuple(vertices)
