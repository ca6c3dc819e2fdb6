"""What can go wrong in the world, each with a sentence that says what would work."""

from movingout.maps.errors import MovingOutError


class WorldError(MovingOutError):
    """The simulated world was used wrongly or left the numbers it can hold."""


class ActionError(WorldError):
    """An action is mis-shaped or not finite."""
