"""Files that people name on the command line or in other files: regular ones, not too large."""

import errno
import os
import stat
from pathlib import Path

MOST_BYTES = 64 << 20


def read_input(path: Path | str, most: int = MOST_BYTES) -> bytes:
    """The bytes of a file. Raises OSError, also for a pipe or device, which might never end, and for an odd name."""
    if "\0" in str(path):
        raise OSError(errno.EINVAL, "a file name has no NUL", str(path).replace("\0", "\\0"))
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    with open(descriptor, "rb") as stream:
        about = os.fstat(descriptor)
        if stat.S_ISDIR(about.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
        if about.st_size > most:
            raise OSError(errno.EFBIG, f"it has more than {most >> 20} MiB", str(path))
        return stream.read(most)
