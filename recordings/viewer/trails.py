"""Lines over the floor as arrays, independent of the viewer."""

from collections.abc import Sequence

import numpy as np

from movingout.world.state import Floats, WorldState

TRAIL_HEIGHT = 0.012  # arena units above the floor


def trail(states: Sequence[WorldState], seat: int, tick: int, ticks: int) -> Floats:
    """Line segments (S, 2, 3) along a robot's way in the last `ticks` ticks; one point when it has no past."""
    first = max(0, tick - ticks)
    points = np.array([states[k].robot_poses[seat, :2] for k in range(first, tick + 1)])
    return segments(np.repeat(points, 2, axis=0) if len(points) == 1 else points, TRAIL_HEIGHT)


def segments(points: Floats, height: float) -> Floats:
    """The lines (P - 1, 2, 3) from point to point (P, 2), at a height."""
    raised = np.column_stack([points, np.full(len(points), height)])
    lines: Floats = np.stack([raised[:-1], raised[1:]], axis=1)
    return lines
