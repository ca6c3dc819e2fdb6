"""Locks on files, which keep other processes out while a file is written."""

import errno
import os
from pathlib import Path

from filelock import lock_descriptor, unlock_descriptor

_NO_LOCKS = (errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP)  # some network and cluster file systems


def lock_file(descriptor: int) -> bool:
    """Lock an open file; whether no other process has it. Where a file system has no locks, nobody is kept out.

    Raises OSError.
    """
    try:
        return lock_descriptor(descriptor, blocking=False)
    except OSError as error:
        if error.errno in _NO_LOCKS:
            return True
        raise


def wait_for_lock(descriptor: int) -> None:
    """Lock an open file as soon as no other process or thread has it; it is given back by closing. Raises OSError."""
    try:
        lock_descriptor(descriptor, blocking=True)
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise


def unlock_file(descriptor: int) -> None:
    """Give a lock back, also while copies of the descriptor are open. Raises OSError."""
    try:
        unlock_descriptor(descriptor)
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise


def _opened(path: Path) -> int:
    """A descriptor to lock: for writing, as some disks want it, or as far as the user may."""
    try:
        return os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except PermissionError:
        return os.open(path, os.O_RDONLY | os.O_CLOEXEC)


def is_locked(path: Path) -> bool:
    """Whether somebody has locked a file, this process or another one; nobody where there is none. Raises OSError."""
    try:
        descriptor = _opened(path)
    except FileNotFoundError:
        return False
    try:
        if not lock_file(descriptor):
            return True
        unlock_file(descriptor)
        return False
    finally:
        os.close(descriptor)
