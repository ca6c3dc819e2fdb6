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
    owner = above.stat()
    path.mkdir(parents=True, exist_ok=True)
    if owner.st_uid != os.geteuid():
        for made in missing:
            with contextlib.suppress(OSError):  # only root can
                os.chown(made, owner.st_uid, owner.st_gid, follow_symlinks=False)


def make_file(path: Path) -> None:
    """Make an empty file; nothing where it is there. Raises OSError."""
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
    except FileExistsError:
        return
    try:
        owner = path.parent.stat()
        if owner.st_uid != os.geteuid():
            with contextlib.suppress(OSError):  # only root can
                os.fchown(descriptor, owner.st_uid, owner.st_gid)
    finally:
        os.close(descriptor)
