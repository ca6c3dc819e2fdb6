"""Files that are written whole, or not at all."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from movingout.maps.errors import MapError


@contextlib.contextmanager
def draft_of(path: Path) -> Iterator[Path]:
    """Where to write a file that replaces `path` when the block ends well; else it is gone. Raises OSError."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")  # two programs may write the same file
    try:
        yield draft
        draft.replace(path)
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
