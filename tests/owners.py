"""Who has which files, for tests of what root makes in the data folder of a server that runs as somebody else."""

import os
from pathlib import Path

import pytest

SERVER = 12345
only_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root makes what belongs to others")


def owners(folder: Path) -> dict[str, int]:
    """Who has what is in a folder, by path from there."""
    return {str(path.relative_to(folder)): path.stat().st_uid for path in sorted(folder.rglob("*"))}
