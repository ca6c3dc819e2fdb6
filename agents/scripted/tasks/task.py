"""A task: the agent has one at a time, and it drives the robot."""

from typing import Protocol

from movingout.agents.scripted.navigation.motion_choice import CollisionCost, DriveCommand
from movingout.agents.scripted.perception import Perception


class Task(Protocol):
    """Something to do. `item` is its item or -1; `infeasible` means that it cannot be done at present."""

    item: int
    infeasible: bool

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """The next command, or None when the task has ended; `slices` limits the planning in this tick."""
        ...
