"""The simulated world: physics, actions, observations, distances, metrics and rewards."""

from movingout.world.errors import ActionError, WorldError
from movingout.world.physics import Snapshot, World
from movingout.world.state import WorldState

__all__ = ["ActionError", "Snapshot", "World", "WorldError", "WorldState"]
