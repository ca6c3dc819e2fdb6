"""Errors of recordings; each message says what would help."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from movingout.maps.errors import MovingOutError


class RecordingError(MovingOutError):
    """A recording cannot be written, read or trusted."""


class BusyError(RecordingError):
    """Another process is writing this journal."""


class UnreadableError(RecordingError):
    """The bytes are not a complete recording of this project."""


@contextmanager
def with_folder(path: Path) -> Iterator[None]:
    """Errors that name a file alone say where it lies, too: for files from several folders."""
    try:
        yield
    except RecordingError as error:
        if path.parent == Path() or str(path) in str(error):
            raise
        raise type(error)(f"{path}: {error}") from error


def cannot(doing: str, path: Path, error: OSError) -> RecordingError:
    """The sentence for an operating system error: what failed, why, and what would help."""
    if error.errno == errno.ELOOP:
        return RecordingError(f"cannot {doing} {path}: it is a link that leads back to itself; remove it")
    if isinstance(error, FileNotFoundError) and path.is_symlink():
        return RecordingError(f"cannot {doing} {path}: it is a link to a file that is not there; remove it")
    if isinstance(error, FileNotFoundError):
        return RecordingError(f"cannot {doing} {path}: there is no such file or folder; check the name")
    if isinstance(error, NotADirectoryError):
        return RecordingError(f"cannot {doing} {path}: a file stands where a folder should be; name a folder")
    if isinstance(error, IsADirectoryError):
        return RecordingError(f"cannot {doing} {path}: it is a folder; name a file")
    why = error.strerror or str(error)
    if error.errno == errno.EINVAL:  # of a file that is none
        return RecordingError(f"cannot {doing} {path}: {why}")
    if isinstance(error, FileExistsError):
        return RecordingError(f"cannot {doing} {path}: {why}; move it away, or choose another folder")
    return RecordingError(f"cannot {doing} {path}: {why}; check free space and permissions, or choose another folder")
