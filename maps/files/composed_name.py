"""Names of files with letters such as ä, which macOS writes as two characters and keyboards elsewhere as one."""

import os
from pathlib import Path
from unicodedata import normalize


def as_stored(path: str) -> str:
    """The path as the disk has it where only this differs: on Linux, the two spellings are two names.

    The path itself where something lies there, and where nothing does in either spelling.
    """
    if path.isascii() or os.path.lexists(path):
        return path
    asked = Path(path)
    found = Path(asked.anchor)
    for part in asked.relative_to(asked.anchor).parts:
        found /= part if os.path.lexists(found / part) else _entry_like(found, part)
    return str(found) if os.path.lexists(found) else path


def _entry_like(folder: Path, name: str) -> str:
    """The entry of a folder that is this name in the other spelling; the name itself for none."""
    wanted = normalize("NFC", name)
    try:
        return next((one for one in sorted(os.listdir(folder)) if normalize("NFC", one) == wanted), name)
    except (OSError, ValueError):  # no such folder; a NUL in its name
        return name
