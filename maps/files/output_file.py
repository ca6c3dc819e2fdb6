"""Files that are written whole, or not at all."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from movingout.maps.errors import MapError
from movingout.maps.files.ownership import give_to_owner_of_folder

_LEFT_S = 3600.0  # a draft that nobody touched for so long is nobody's, on other machines with the same folder, too


@contextlib.contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Where to write a file that replaces `path` when the block ends well; else it is gone. Raises OSError.

    Drafts of the same file that crashed programs left are removed.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}")  # two programs may write the same file
    try:
        yield draft
        give_to_owner_of_folder(draft)
        draft.replace(path)
        _remove_left(path)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def write_output(path: Path, content: bytes) -> None:
    """Write a file, over an older one if there is one. Raises MapError; what was there before is then still there."""
    try:
        with draft_of(path) as draft:
            draft.write_bytes(content)
    except OSError as error:
        raise MapError(f"cannot write {path}: {error.strerror or error}") from error


def check_output(path: Path) -> None:
    """Make the folder of a file that is written later. Raises MapError when `write_output` could not write it."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise MapError(f"cannot write {path}: {error.strerror or error}") from error


def _remove_left(path: Path) -> None:
    """Of a file that has just been written: its time is the present one, by the clock of the folder's machine."""
    with contextlib.suppress(OSError), os.scandir(path.parent) as entries:
        now = path.stat().st_mtime
        for entry in entries:
            pid = entry.name.removeprefix(f".{path.name}.")
            if pid == entry.name or not (pid.isascii() and pid.isdecimal()) or _lives(int(pid)):
                continue
            with contextlib.suppress(OSError):  # removed meanwhile, or somebody else's
                if now - entry.stat().st_mtime > _LEFT_S:
                    os.unlink(entry)


def _lives(pid: int) -> bool:
    """Whether a process has this number; True where that cannot be told."""
    if os.name != "posix":
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
