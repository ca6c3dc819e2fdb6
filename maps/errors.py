"""The one base of every error that this project raises on purpose."""


class MovingOutError(Exception):
    """Base of all expected errors. Its message says what was wrong and what would work."""


class MapError(MovingOutError):
    """A map is unknown, unreadable or faulty."""
