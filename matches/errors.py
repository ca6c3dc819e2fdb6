"""The error of this package."""

from movingout.maps.errors import MovingOutError


class MatchError(MovingOutError):
    """A grid is faulty, a results folder is not the grid's, or results cannot be written."""
