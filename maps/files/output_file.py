"""Files that commands write: whole, or not at all."""

import os
from pathlib import Path

from movingout.maps.errors import MapError


def write_output(path: Path, content: bytes) -> None:
    """Write a file, over an older one if there is one. Raises MapError; what was there before is then still there."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_bytes(content)
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise MapError(f"cannot write {path}: {error.strerror or error}") from error
