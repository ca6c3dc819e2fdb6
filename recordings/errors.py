"""What can go wrong with a recording, as one error with a sentence."""

from pathlib import Path

from maps.errors import MovingOutError


class RecordingError(MovingOutError):
    """A recording cannot be written, read or trusted."""


def cannot(doing: str, path: Path, error: OSError) -> RecordingError:
    """The sentence for an operating system error: what failed, why, and what would help."""
    why = error.strerror or str(error)
    return RecordingError(f"cannot {doing} {path}: {why}; check free space and permissions, or choose another folder")
