"""The simulated world."""

from world.errors import ActionError, WorldError
from world.physics import Snapshot, World
from world.state import WorldState

__all__ = ["ActionError", "Snapshot", "World", "WorldError", "WorldState"]
