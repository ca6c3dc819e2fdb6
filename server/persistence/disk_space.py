"""How much may still be written: to the data folder, and to the recordings, which may have a disk of their own."""

import shutil
from pathlib import Path
from typing import Final

LEAST_FREE: Final = 50e6  # bytes, below which nothing new is begun


def disk_free(data: Path, recordings: Path) -> int:
    """Bytes on the disk of the data folder, or of the recordings where theirs has less; 0 when one is gone.

    Asking whether a folder is there raises where its disk answers with an error.
    """
    try:
        folders = [data, *([recordings] if recordings.exists() else [])]
        return min(shutil.disk_usage(folder).free for folder in folders)
    except OSError:
        return 0
