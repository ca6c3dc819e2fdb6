"""What a scripted player can be busy with: one thing at a time, each driving its robot."""

from typing import Protocol

from movingout.agents.scripted.navigation.motion_choice import Command, Danger
from movingout.agents.scripted.situation import Situation


class Errand(Protocol):
    """One thing to do. `item` is what it is about, -1 for nothing; `hopeless` says that it cannot be done now."""

    item: int
    hopeless: bool

    def step(self, now: Situation, danger: Danger, slices: int) -> Command | None:
        """The next command, or None when it is over; `slices` is how much it may think."""
        ...
