"""The simulated world."""

from world.state import WorldState

__all__ = ["WorldState"]
