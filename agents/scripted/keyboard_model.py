"""A hand on keys: eight directions, forward or backward, at full or no deflection.

Who wants another direction or a slower pace taps: of all that can be pressed for a tick, that is pressed which brings
the robot nearest to where it should be by now; what is missing or too much then is made up for later.
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
_KEPT = np.array([0.9, 0.9, 0.5])  # share of what is missing that is not forgotten from tick to tick


class KeyboardModel:
    """The keys of one seat in one episode."""

    def __init__(self, the_map: MapSpec, seat: int) -> None:
        self._map = the_map
        self._seat = seat
        self._missing = np.zeros(3)  # x, y [u], angle [rad]
        self._turns_to: float | None = None  # a robot goes on turning to where the last key pointed

    def press(self, state: WorldState, distance: float, heading: float) -> tuple[float, float]:
        """Distance (-1, 0 or 1) and heading to press, for who would like to drive so from `state`."""
        hand, angle = self._hand(state), float(state.robot_poses[self._seat, 2])
        turns_to = angle if self._turns_to is None else self._turns_to
        if self._seat == 1:  # red's command takes effect after half of a tick
            angle += min(max(turns_to - angle, -_TURN / 2), _TURN / 2)
        wanted = _motion(distance, heading, angle, turns_to, hand)[1] + self._missing
        options = [_motion(*choice, angle, turns_to, hand) for choice in _CHOICES]
        lacks = np.array([wanted - motion for _, motion in options])
        best = int(np.argmin(((lacks / _UNITS) ** 2).sum(axis=1)))
        self._missing = _KEPT * np.clip(lacks[best], -_UNITS, _UNITS)
        self._turns_to = options[best][0]
        return _CHOICES[best]

    def _hand(self, state: WorldState) -> Hand:
        """What the robot holds, as far as it matters for driving."""
        item = int(state.held[self._seat])
        if item < 0:
            return Hand()
        size, together = self._map.items[item].size, item == int(state.held[1 - self._seat])
        slow = size == "middle" and not together
        return Hand(slow=slow, together=together, aligns=slow, quick=size == "small")


def _motion(distance: float, heading: float, angle: float, turns_to: float, hand: Hand) -> tuple[float, Floats]:
    """To which angle [rad] a robot turns, and how it moves in a tick: x, y [u] and angle [rad]."""
    target, vx, vy = drive_command(distance, heading, angle=angle, control_angle=turns_to, hand=hand)
    turn = min(max(target - angle, -_TURN), _TURN)
    return target, np.array([vx * TICK_SECONDS, vy * TICK_SECONDS, turn])
