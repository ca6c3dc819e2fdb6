"""What a scripted player can be busy with: one thing at a time, each driving its robot."""

from typing import Protocol

from movingout.agents.scripted.navigation.motion_choice import CollisionCost, DriveCommand
from movingout.agents.scripted.perception import Perception


class Task(Protocol):
    """One thing to do. `item` is what it is about, -1 for nothing; `hopeless` says that it cannot be done now."""

    item: int
    infeasible: bool

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """The next command, or None when it is over; `slices` is how much it may think."""
        ...
