"""A new HDF5 file whose failed writes are one OSError.

The HDF5 library tells of a full disk by dozens of messages on standard error and leaves the file open. So it writes
through an object that keeps the first fault and lets the library go on as if all was well.
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py


@contextlib.contextmanager
def hdf5_file(path: Path) -> Iterator[Any]:
    """The open file. Raises OSError when it cannot be opened, or at the end when something was not written."""
    with open(path, "w+b", buffering=0) as raw:
        output = _Output(raw)
        with h5py.File(output, "w") as file:
            yield file
    if output.fault is not None:
        raise output.fault


class _Output:
    """What h5py needs of a file, without errors when writing."""

    def __init__(self, raw: Any) -> None:
        self._raw = raw
        self.fault: OSError | None = None  # the first one; nothing is written after it
        self.seek = raw.seek
        self.tell = raw.tell
        self.readinto = raw.readinto
        self.flush = raw.flush

    def read(self, size: int = -1) -> bytes:
        return bytes(self._raw.read(size))

    def write(self, data: Any) -> int:
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while left and self.fault is None:
                left = left[self._raw.write(left) :]
        except OSError as error:
            self.fault = error
        return size

    def truncate(self, size: int | None = None) -> int:
        try:
            return int(self._raw.truncate(size))
        except OSError as error:
            self.fault = self.fault or error
            return self._raw.seek(0, os.SEEK_END) if size is None else size
