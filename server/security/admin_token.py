"""The admin token of a data folder: made at the first start and kept, so that links and open pages survive a restart.

It is stored beside the data in a file that only its owner may read, like the key of the certificate. A file that others
can read, or that holds no token, is replaced: what others may have seen is not a secret.
"""

import os
import re
import stat
import tempfile
from pathlib import Path

from movingout.server.security.tokens import new_token

NAME = "admin-token"
_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,128}")  # one that was typed by hand will do, if it is long enough


def kept_token(data: Path) -> str:
    """The token of this folder. Raises OSError."""
    path = data / NAME
    return _read(path) or _keep(path, new_token())


def _read(path: Path) -> str:
    """The token in the file; empty if there is none or it is no longer secret."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return ""
    try:
        about = os.fstat(descriptor)
        private = stat.S_ISREG(about.st_mode) and about.st_uid == os.geteuid() and not about.st_mode & 0o077
        found = _TOKEN.fullmatch(os.read(descriptor, 256).decode("ascii", "replace").strip()) if private else None
    finally:
        os.close(descriptor)
    return found[0] if found else ""


def _keep(path: Path, token: str) -> str:
    """Write atomically, and never readable by others."""
    descriptor, part = tempfile.mkstemp(prefix=f".{NAME}-", dir=path.parent)  # mode 0600
    try:
        with open(descriptor, "w", encoding="ascii") as stream:
            stream.write(f"{token}\n")
        os.replace(part, path)
    except OSError:
        os.unlink(part)
        raise
    return token
