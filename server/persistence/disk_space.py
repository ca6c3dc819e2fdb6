"""How much may still be written: to the data folder, and to the recordings, which may have a disk of their own."""

import contextlib
import shutil
from pathlib import Path
from typing import Final

LEAST_FREE: Final = 50e6  # bytes, below which nothing new is begun


def disk_free(data: Path, recordings: Path) -> int:
    """Bytes on the disk of the data folder, or of the recordings where theirs has less; 0 when one is gone or broken.

    A folder of recordings that is not made yet decides nothing.
    """
    try:
        free = shutil.disk_usage(data).free
        with contextlib.suppress(FileNotFoundError):
            recordings.stat()  # the size of a disk may be known that no longer answers
            free = min(free, shutil.disk_usage(recordings).free)
    except OSError:
        return 0
    return free
