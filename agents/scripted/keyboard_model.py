"""Keyboard control: eight directions, forward or backward, at full deflection or none.

Other directions and lower speeds are approximated by tapping, as in error diffusion: each tick presses the keys that
bring the robot nearest to where it should be, and carries the remaining error over to the next tick.
"""

import math

import numpy as np

from movingout.maps import MapSpec
from movingout.world.constants import DRIVE_SPEED, TICK_SECONDS, TURN_MAX_SPEED
from movingout.world.drive import Hand, drive_command
from movingout.world.state import Floats, WorldState

_DIRECTIONS = tuple(k * math.pi / 4 for k in range(-3, 5))  # headings [rad]
_CHOICES = ((0.0, 0.0), *((sign, heading) for sign in (1.0, -1.0) for heading in _DIRECTIONS))
_STRIDE = DRIVE_SPEED * TICK_SECONDS  # u in a tick
_TURN = TURN_MAX_SPEED * TICK_SECONDS  # rad in a tick
_UNITS = np.array([_STRIDE, _STRIDE, _TURN])
_KEPT = np.array([0.9, 0.9, 0.5])  # share of the error that is carried over from tick to tick


class KeyboardModel:
    """The keyboard of one seat in one episode."""

    def __init__(self, the_map: MapSpec, seat: int) -> None:
        self._map = the_map
        self._seat = seat
        self._missing = np.zeros(3)  # x, y [u], angle [rad]
        self._turns_to: float | None = None  # a robot keeps turning to the last commanded heading

    def press(self, state: WorldState, distance: float, heading: float) -> tuple[float, float]:
        """Distance (-1, 0 or 1) and heading [rad] of the keys to press for the wanted distance and heading."""
        hand, angle = self._hand(state), float(state.robot_poses[self._seat, 2])
        turns_to = angle if self._turns_to is None else self._turns_to
        if self._seat == 1:  # red's command takes effect after half a tick
            angle += min(max(turns_to - angle, -_TURN / 2), _TURN / 2)
        wanted = _motion(distance, heading, angle, turns_to, hand)[1] + self._missing
        options = [_motion(*choice, angle, turns_to, hand) for choice in _CHOICES]
        lacks = np.array([wanted - motion for _, motion in options])
        best = int(np.argmin(((lacks / _UNITS) ** 2).sum(axis=1)))
        self._missing = _KEPT * np.clip(lacks[best], -_UNITS, _UNITS)
        self._turns_to = options[best][0]
        return _CHOICES[best]

    def _hand(self, state: WorldState) -> Hand:
        """What the robot holds, as the drive model needs it."""
        item = int(state.held[self._seat])
        if item < 0:
            return Hand()
        size, together = self._map.items[item].size, item == int(state.held[1 - self._seat])
        slow = size == "middle" and not together
        return Hand(slow=slow, together=together, aligns=slow, quick=size == "small")


def _motion(distance: float, heading: float, angle: float, turns_to: float, hand: Hand) -> tuple[float, Floats]:
    """(angle [rad] that the robot turns to, motion (3,) in one tick: x, y [u] and angle [rad])."""
    target, vx, vy = drive_command(distance, heading, angle=angle, control_angle=turns_to, hand=hand)
    turn = min(max(target - angle, -_TURN), _TURN)
    return target, np.array([vx * TICK_SECONDS, vy * TICK_SECONDS, turn])
