"""Folders and files that root makes in a data folder, for commands that are given before or beside a server.

They belong to whom the folder above them belongs: the server, which runs as a user of its own, could not use them else.
"""

import contextlib
import os
from pathlib import Path


def make_folder(path: Path) -> None:
    """Make a folder and those above it that are missing; nothing where it is there. Raises OSError."""
    missing = []
    above = path
    while not above.exists():
        missing.append(above)
        above = above.parent
    path.mkdir(parents=True, exist_ok=True)
    for made in reversed(missing):
        give_to_owner_of_folder(made)


def make_file(path: Path) -> None:
    """Make an empty file; nothing where it is there. Raises OSError."""
    try:
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
    except FileExistsError:
        return
    give_to_owner_of_folder(path)


def give_to_owner_of_folder(made: Path) -> None:
    """What root has made belongs to whom the folder it lies in belongs."""
    if os.name == "posix" and os.geteuid() == 0:
        with contextlib.suppress(OSError):  # a file system without owners
            owner = made.parent.stat()
            os.chown(made, owner.st_uid, owner.st_gid, follow_symlinks=False)
