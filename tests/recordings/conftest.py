"""Disks that are full: files of this process cannot grow beyond a limit."""

import resource
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.recordings.support import record


@pytest.fixture
def small_files() -> Iterator[int]:
    """Writes beyond 60,000 bytes of a file fail as on a full disk."""
    limit = 60_000
    yield from _limited(limit)


@pytest.fixture
def tiny_files() -> Iterator[int]:
    """Not even the head of a journal fits."""
    yield from _limited(4_000)


@pytest.fixture
def journal_then_small_files(tmp_path: Path) -> Iterator[Path]:
    """A closed journal, and then no room for a recording."""
    journal, _ = record(tmp_path, ticks=30)
    for _ in _limited(10_000):
        yield journal


def _limited(limit: int) -> Iterator[int]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # write() then fails with EFBIG instead
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        yield limit
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


@pytest.fixture
def all_bytes() -> Callable[[Path], bytes]:
    """Everything in a file or folder, names included."""

    def read(target: Path) -> bytes:
        files = [target] if target.is_file() else sorted(path for path in target.rglob("*") if path.is_file())
        return b"".join(str(path.relative_to(target)).encode() + path.read_bytes() for path in files)

    return read
