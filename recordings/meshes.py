"""The bodies of a map as 3D solids: extruded outlines, shared by the Foxglove scene and the viser viewer."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.maps.shapes import outline
from movingout.maps.spec import ROBOT_RADIUS, ItemSpec, MapSpec, Rect

WALL_HEIGHT = 0.12  # arena units; heights are for looking at, the world is flat
ROBOT_HEIGHT = 0.10
ITEM_HEIGHT = 0.08
GOAL_HEIGHT = 0.004
_CIRCLE_CORNERS = 32

Colour = tuple[float, float, float]  # red, green, blue in [0, 1]
Pixel = tuple[int, int, int]  # the same from 0 to 255
SEAT_RGB: tuple[Colour, Colour] = ((0.0, 0.447, 0.698), (0.835, 0.369, 0.0))  # colour-blind safe blue and vermilion
ITEM_RGB: Colour = (0.73, 0.73, 0.73)
DELIVERED_RGB: Colour = (0.56, 0.72, 0.54)
WALL_RGB: Colour = (0.25, 0.27, 0.30)
GOAL_RGB: Colour = (0.56, 0.79, 0.56)


class Mesh(NamedTuple):
    """A closed triangle mesh in its body's own frame, z up from the floor."""

    vertices: npt.NDArray[np.float64]  # (V, 3)
    triangles: npt.NDArray[np.int64]  # (F, 3) indices, counter-clockwise seen from outside


def pixel(colour: Colour) -> Pixel:
    """A colour for libraries that take bytes."""
    red, green, blue = (round(255 * channel) for channel in colour)
    return red, green, blue


def prism(corners: list[tuple[float, float]], height: float) -> Mesh:
    """An upright prism over counter-clockwise corners that are all visible from the origin of their mean."""
    count = len(corners)
    ring = np.array(corners, dtype=np.float64)
    centre = ring.mean(axis=0)
    plane = np.vstack([ring, centre])
    bottom = np.column_stack([plane, np.zeros(count + 1)])
    top = np.column_stack([plane, np.full(count + 1, height)])
    this = np.arange(count)
    following = (this + 1) % count
    middle = np.full(count, count)
    up = count + 1  # index of the first top vertex
    triangles = [
        np.column_stack([middle, following, this]),
        np.column_stack([middle + up, this + up, following + up]),
        np.column_stack([this, following, following + up]),
        np.column_stack([this, following + up, this + up]),
    ]
    return Mesh(np.vstack([bottom, top]), np.vstack(triangles))


def circle(radius: float) -> list[tuple[float, float]]:
    """The corners that stand for a circle."""
    steps = (2 * math.pi * k / _CIRCLE_CORNERS for k in range(_CIRCLE_CORNERS))
    return [(radius * math.cos(step), radius * math.sin(step)) for step in steps]


def robot_mesh() -> Mesh:
    return prism(circle(ROBOT_RADIUS), ROBOT_HEIGHT)


def nose_mesh() -> Mesh:
    """A wedge on top of a robot that shows where it looks (+y at angle 0)."""
    tip, half = ROBOT_RADIUS * 1.15, ROBOT_RADIUS * 0.35
    return prism([(-half, ROBOT_RADIUS * 0.35), (half, ROBOT_RADIUS * 0.35), (0.0, tip)], ROBOT_HEIGHT * 1.2)


def item_mesh(item: ItemSpec) -> Mesh:
    return prism(list(outline(item.shape, item.scale)) or circle(item.scale), ITEM_HEIGHT)


def rect_mesh(rect: Rect, height: float) -> Mesh:
    corners = [(rect.left, rect.bottom), (rect.right, rect.bottom), (rect.right, rect.top), (rect.left, rect.top)]
    return prism(corners, height)


def map_meshes(spec: MapSpec) -> list[tuple[str, Mesh, Colour]]:
    """What never moves, with a name and a colour each."""
    goals = [(f"goal/{k}", rect_mesh(goal, GOAL_HEIGHT), GOAL_RGB) for k, goal in enumerate(spec.goals)]
    walls = [(f"wall/{k}", rect_mesh(wall, WALL_HEIGHT), WALL_RGB) for k, wall in enumerate(spec.walls)]
    return goals + walls
