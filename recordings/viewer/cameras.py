"""Camera presets of the viewer."""

import math
from typing import NamedTuple

from movingout.world.state import Floats

Vector = tuple[float, float, float]

CORNER, ABOVE, LOW, BLUE, RED = "Corner", "Above", "Low", "Blue", "Red"
PRESETS = (CORNER, ABOVE, LOW, BLUE, RED)
_BEHIND, _OVER = 0.9, 0.7  # arena units behind and over a robot
_SEATS = {BLUE: 0, RED: 1}


class Camera(NamedTuple):
    """Position, look-at point and up direction."""

    position: Vector
    look_at: Vector
    up: Vector


def camera(preset: str, width: float, robots: Floats) -> Camera:
    """The preset for arenas side by side that are `width` wide, centred on the origin; `robots` is (2, 3).

    Blue and Red look over that robot's shoulder.
    """
    if preset in _SEATS:
        return _behind(robots[_SEATS[preset]].tolist())
    if preset == ABOVE:
        return Camera((0.0, 0.0, 0.5 * width + 0.75), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    away = 0.62 * width + 1.05  # all corners fit a window a little wider than high, at viser's field of view
    if preset == LOW:
        return Camera((0.0, -away, 0.25 * away), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    return Camera((0.1 * away, -0.7 * away, 0.72 * away), (0.0, -0.1, 0.0), (0.0, 0.0, 1.0))


def _behind(pose: list[float]) -> Camera:
    x, y, angle = pose
    ahead = (-math.sin(angle), math.cos(angle))  # angle 0 looks along +y
    position = (x - _BEHIND * ahead[0], y - _BEHIND * ahead[1], _OVER)
    return Camera(position, (x + 0.4 * ahead[0], y + 0.4 * ahead[1], 0.0), (0.0, 0.0, 1.0))
