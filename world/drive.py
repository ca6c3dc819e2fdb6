"""The controller: from a robot's command to the target angle and velocity of the body that steers it.

Pure arithmetic of the official controller, in its exact order of operations.
"""

import math
from typing import NamedTuple

from movingout.world import constants as c


class Hand(NamedTuple):
    """How what a robot holds changes its driving; an empty hand is the default."""

    slow: bool = False  # alone with a middle item
    together: bool = False  # both hold one item
    aligns: bool = False  # turns to the nearer end of its own axis: alone with a middle, left with a large item
    quick: bool = True  # empty or with a small item: turns first, then drives


EMPTY_HAND = Hand()


def drive_command(
    distance: float, heading: float, *, angle: float, control_angle: float, hand: Hand
) -> tuple[float, float, float]:
    """(target angle [rad], vx, vy [u/s]) of the control body.

    `heading` 0 looks along +y, counter-clockwise; a negative distance drives backwards. `angle` and
    `control_angle` are those of the robot and of its control body, `hand` is what it holds.
    """
    control_angle = angle + _clip(control_angle - angle)
    dx, dy = distance * math.cos(heading), distance * math.sin(heading)
    stands = dx == 0 and dy == 0
    error = _turn(_wrap((control_angle if stands else heading) - angle), hand)
    if hand.slow or (hand.quick and abs(error) >= c.TURN_FIRST_ANGLE):
        dx, dy = c.SLOW_FACTOR * dx, c.SLOW_FACTOR * dy
    if abs(dx) + abs(dy) < c.DRIVE_DEAD_ZONE:
        return error + angle, 0.0, 0.0
    return error + angle, -c.DRIVE_SPEED * dy, c.DRIVE_SPEED * dx


def _turn(error: float, hand: Hand) -> float:
    if hand.together:
        if abs(error) > math.pi / 2:
            error = math.copysign(math.pi, error) - error
        error = error / c.TOGETHER_TURN_DIVISOR
    elif hand.aligns and abs(error) > math.pi / 2:
        error = error - math.copysign(math.pi, error)
    if hand.slow:
        error = error / c.SLOW_TURN_DIVISOR
    return _clip(error)


def _clip(angle: float) -> float:
    return angle if -c.TURN_LIMIT <= angle <= c.TURN_LIMIT else math.copysign(c.TURN_LIMIT, angle)


def _wrap(angle: float) -> float:
    """The angle in [-pi, pi), by the two modulo operations that equality to the bit requires."""
    full = 2 * math.pi
    return (angle % full + math.pi) % full - math.pi
