"""Errors of the simulated world; each message says what would work."""

from movingout.maps.errors import MovingOutError


class WorldError(MovingOutError):
    """The world was used incorrectly, or its numbers are no longer finite."""


class ActionError(WorldError):
    """An action has the wrong shape or is not finite."""
