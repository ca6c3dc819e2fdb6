"""The target of an export: it appears complete or not at all."""

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path

from movingout.recordings.errors import RecordingError, cannot


@contextlib.contextmanager
def new_target(target: Path) -> Iterator[Path]:
    """A path beside the target to build a file or folder at; it becomes the target when the block ends well.

    Raises RecordingError.
    """
    if target.exists():
        raise RecordingError(f"{target} exists already and is not overwritten; choose another name")
    part = target.with_name(target.name + ".part")
    _remove(part)  # of an attempt that was killed
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.rename(target)
    except OSError as error:
        raise cannot("write", target, error) from error
    finally:
        _remove(part)


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
