"""Where a body spent its time: seconds per cell of the arena, for heat maps in the viewer and in reports."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from movingout.maps.spec import ARENA_HALF
from movingout.recordings.meshes import SEAT_RGB
from movingout.world.constants import TICK_SECONDS
from movingout.world.state import Floats, WorldState

HEAT_OPACITY = 0.85
CELLS = 48  # per side: cells of 0.05 arena units, as in the distance grid of the metrics


def occupancy(states: Sequence[WorldState], seat: int, cells: int = CELLS) -> Floats:
    """Seconds (cells, cells) that a robot's centre was in each cell; row 0 is the bottom, column 0 the left.

    The first state is the start, in which no time passed.
    """
    return time_per_cell(np.array([state.robot_poses[seat, :2] for state in states[1:]]), cells)


def time_per_cell(places: Floats, cells: int = CELLS) -> Floats:
    """Seconds (cells, cells) spent in each cell, given the places (T, 2) after each tick; rows and columns as above."""
    points = places.reshape(-1, 2)
    edges = np.linspace(-ARENA_HALF, ARENA_HALF, cells + 1)
    inside = np.clip(points, edges[0], np.nextafter(edges[-1], 0.0))
    counts, _, _ = np.histogram2d(inside[:, 1], inside[:, 0], bins=(edges, edges))
    return np.asarray(counts * TICK_SECONDS, dtype=np.float64)


def smoothed(grid: Floats) -> Floats:
    """The grid, each cell spread over its 3 x 3 neighbourhood (weights 1 2 1), so that tracks read as areas."""
    padded = np.pad(grid, 1)
    rows = (padded[:-2] + 2 * padded[1:-1] + padded[2:]) / 4
    both: Floats = (rows[:, :-2] + 2 * rows[:, 1:-1] + rows[:, 2:]) / 4
    return both


def shades(grid: Floats) -> Floats:
    """The grid as strengths in [0, 1]: square roots, so that a long stop does not hide the paths between."""
    top = float(grid.max(initial=0.0))
    return np.sqrt(grid / top) if top > 0.0 else np.zeros_like(grid)


def heat_picture(grids: Sequence[Floats], seats: Sequence[int], pixels: int) -> npt.NDArray[np.uint8]:
    """An RGBA picture, top row first, of the time that the named seats spent in each cell of `grids` (blue's, red's).

    A cell is `pixels` x `pixels` large.
    """
    size = grids[0].shape[0]
    colour, weight = np.zeros((size, size, 3)), np.zeros((size, size))
    for seat in seats:
        strength = shades(grids[seat])
        colour += strength[..., None] * np.array(SEAT_RGB[seat])
        weight += strength
    colour /= np.maximum(weight, 1e-9)[..., None]
    rgba = np.dstack([colour, np.clip(weight, 0.0, 1.0) * HEAT_OPACITY])
    cells = np.rint(255 * rgba).astype(np.uint8)[::-1]
    return np.repeat(np.repeat(cells, pixels, axis=0), pixels, axis=1)
