"""The controls of one player: the newest stick position and the waiting presses of the grab button.

The stick is a level, so the newest packet wins. Presses are edges and carry a counter, so that neither a lost nor a
duplicated packet changes how often the hand toggles. Knows no socket and no clock: times are arguments.
"""

from typing import NamedTuple

import msgspec

from movingout.server.frames import Input
from movingout.server.messages import DEVICES
from movingout.world.state import Floats

STALE_S = 0.5  # without an input for so long the stick counts as released
MAX_PRESSES = 4  # presses waiting for their tick; more are a mistake


class TickInput(NamedTuple):
    """What a seat does in one tick, and which input that was."""

    action: tuple[float, float, float] | Floats  # distance, heading [rad], grasp toggle
    seq: int  # -1: no input
    slack_ms: float  # how long before the tick the input came, -1 unknown
    fresh: bool  # False: neutral because the input was stale or there was none


NEUTRAL = TickInput((0.0, 0.0, 0.0), -1, -1.0, False)


class InputBuffer:
    """One seat's controls, from the `Welcome` of one socket on."""

    def __init__(self) -> None:
        self.newest: Input | None = None  # with the stick at rest after a release
        self._arrived = 0.0
        self._presses = 0

    def submit(self, frame: Input, now: float) -> bool:
        """Store an input; False if it is not newer than the last one."""
        seen = 0 if self.newest is None else self.newest.grabs
        if self.newest is not None and frame.seq <= self.newest.seq:
            return False
        self._presses = min(MAX_PRESSES, self._presses + (frame.grabs - seen) % 256)
        self.newest, self._arrived = frame, now
        return True

    def tick_input(self, now: float) -> TickInput:
        """The input for the tick that starts now; one waiting press toggles the hand."""
        newest = self.newest
        if newest is None or now - self._arrived > STALE_S:
            return NEUTRAL
        toggle = self._presses > 0
        self._presses -= toggle
        slack_ms = max(0.0, (now - self._arrived) * 1e3)
        return TickInput((newest.move, newest.heading, float(toggle)), newest.seq, slack_ms, True)

    def release(self) -> None:
        """Let go of the stick: the page lost the focus, or play starts again."""
        self._presses = 0
        if self.newest is not None:
            self.newest = msgspec.structs.replace(self.newest, move=0.0)

    @property
    def device(self) -> str:
        """Empty before the first input."""
        return "" if self.newest is None else DEVICES[self.newest.device]
