"""Files that people name on the command line or in other files: regular ones, not too large."""

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

MOST_BYTES = 64 << 20


def open_input(path: Path | str) -> BinaryIO:
    """A file to read. Raises OSError, also for a pipe or device, which might never end, and for an odd name."""
    if "\0" in str(path):
        raise OSError(errno.EINVAL, "a file name has no NUL", str(path).replace("\0", "\\0"))
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
    except OSError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def read_input(path: Path | str, most: int = MOST_BYTES) -> bytes:
    """The bytes of a file. Raises OSError, also for one that is too large or that `open_input` refuses."""
    with open_input(path) as stream:
        if os.fstat(stream.fileno()).st_size > most:
            raise OSError(errno.EFBIG, f"it has more than {most >> 20} MiB", str(path))
        return stream.read(most)
