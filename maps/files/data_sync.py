"""Making what was written to a file survive a power failure. Blocks for the disk."""

import os


def sync_data(descriptor: int) -> None:
    """Flush the file's contents, and of what describes it only what reading them needs. Raises OSError."""
    flush = getattr(os, "fdatasync", os.fsync)  # macOS has fsync only
    flush(descriptor)
