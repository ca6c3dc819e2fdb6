"""Disks that are full, and all bytes of a folder."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.recordings.full_disk import limited
from tests.recordings.support import record


@pytest.fixture
def small_files() -> Iterator[int]:
    """Writes beyond 60,000 bytes of a file fail as on a full disk."""
    with limited(60_000) as limit:
        yield limit


@pytest.fixture
def tiny_files() -> Iterator[int]:
    """Not even the head of a journal fits."""
    with limited(4_000) as limit:
        yield limit


@pytest.fixture
def journal_then_small_files(tmp_path: Path) -> Iterator[Path]:
    """A closed journal, and then no room for a recording."""
    journal, _ = record(tmp_path, ticks=30)
    with limited(10_000):
        yield journal


@pytest.fixture
def all_bytes() -> Callable[[Path], bytes]:
    """Everything in a file or folder, names included."""

    def read(target: Path) -> bytes:
        files = [target] if target.is_file() else sorted(path for path in target.rglob("*") if path.is_file())
        return b"".join(str(path.relative_to(target)).encode() + path.read_bytes() for path in files)

    return read
