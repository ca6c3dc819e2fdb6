"""A secret of a data folder, made when it is first needed and kept in a file that only its owner may read.

A file that others can read, or that holds no secret, is of no use: what others may have seen is not a secret.
"""

import contextlib
import os
import re
import stat
import tempfile
from pathlib import Path

from movingout.server.security.tokens import new_token

_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,128}")  # one that was typed by hand will do, if it is long enough


def kept_secret(path: Path, *, replace: bool = True) -> str:
    """The secret in this file, made if there is none. A file of no use is replaced, or else the secret is empty.

    Raises OSError.
    """
    return _read(path) or _make(path, new_token(), replace)


def _read(path: Path) -> str:
    """The secret in the file; empty if there is none or others may have read it."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return ""
    try:
        about = os.fstat(descriptor)
        owners = os.geteuid(), path.parent.stat().st_uid  # root reads what the server keeps in a folder of its own
        private = stat.S_ISREG(about.st_mode) and about.st_uid in owners and not _others_may_read(about, path.parent)
        found = _TOKEN.fullmatch(os.read(descriptor, 256).decode("ascii", "replace").strip()) if private else None
    finally:
        os.close(descriptor)
    return found[0] if found else ""


def _others_may_read(about: os.stat_result, folder: Path) -> bool:
    if not about.st_mode & 0o077:
        return False
    # A new file has the mode 0600, but not on drives of Windows under WSL or Docker.
    with tempfile.NamedTemporaryFile(dir=folder) as probe:
        return not os.fstat(probe.fileno()).st_mode & 0o077


def _make(path: Path, token: str, replace: bool) -> str:
    """Of several programs that make it at once, all come back with the same secret."""
    made = _keep(path, token, replace=False) or _read(path)
    return made or (_keep(path, token, replace=True) if replace else "")


def _keep(path: Path, token: str, replace: bool) -> str:
    """Write atomically, and never readable by others; empty where there is such a file already."""
    descriptor, part = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)  # mode 0600
    folder = path.parent.stat()
    if folder.st_uid != os.fstat(descriptor).st_uid:
        with contextlib.suppress(OSError):  # only root can: the server that keeps the folder is to read it
            os.fchown(descriptor, folder.st_uid, folder.st_gid)
    try:
        with open(descriptor, "w", encoding="ascii") as stream:
            stream.write(f"{token}\n")
        if replace:
            os.replace(part, path)
        else:
            os.link(part, path)
            os.unlink(part)
    except FileExistsError:
        os.unlink(part)
        return ""
    except OSError:
        os.unlink(part)
        raise
    return token
