"""Every preset that shows the whole scene shows all its corners, in a window a little wider than high."""

import math

import numpy as np
import pytest

from movingout.recordings.viewer.cameras import ABOVE, CORNER, LOW, Camera, camera
from movingout.recordings.viewer.side_by_side import row_width

FIELD_OF_VIEW = math.radians(75.0)  # viser's, from top to bottom
ASPECT = 1.25  # what viser's own panel leaves of a usual window
MARGIN = 0.95


def farthest(view: Camera, corners: list[tuple[float, float, float]]) -> float:
    """How far out the outermost corner is: 1 is the edge of the window."""
    position = np.array(view.position)
    ahead = np.array(view.look_at) - position
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, np.array(view.up))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    half = math.tan(FIELD_OF_VIEW / 2)
    ways = [np.array(corner) - position for corner in corners]
    return float(max(max(abs(way @ right) / ASPECT, abs(way @ up)) / (way @ ahead) / half for way in ways))


@pytest.mark.parametrize("arenas", [1, 2])
@pytest.mark.parametrize("preset", [CORNER, ABOVE, LOW])
def test_no_corner_is_cut_off(preset: str, arenas: int) -> None:
    width = row_width(arenas)
    corners = [(x, y, 0.0) for x in (-width / 2, width / 2) for y in (-1.2, 1.2)]
    assert farthest(camera(preset, width, np.zeros((2, 3))), corners) <= MARGIN
