"""Collisions of the two robots, detected from states."""

import math

from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.constants import TICK_SECONDS
from movingout.world.state import WorldState

TOUCHING = 0.005  # u; robots that push each other stay nearer than this, to the engine's slop of 0.001


def collision_speed(before: WorldState, after: WorldState) -> float:
    """How fast the robots came together [u/s] when their contact began in the tick between two states, else 0.

    States are 100 ms apart: a contact that begins and ends between two of them is not seen.
    """
    was, now = _gap(before), _gap(after)
    return (was - now) / TICK_SECONDS if now <= TOUCHING < was else 0.0


def _gap(state: WorldState) -> float:
    """Distance [u] between the edges of the robots, which are discs."""
    (blue_x, blue_y, _), (red_x, red_y, _) = state.robot_poses.tolist()
    return math.hypot(blue_x - red_x, blue_y - red_y) - 2 * ROBOT_RADIUS
