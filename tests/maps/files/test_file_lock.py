"""Where a file system has no locks, as on some clusters, files are written all the same."""

import errno
import os
from pathlib import Path

import pytest

from movingout.maps.files import file_lock
from movingout.matches.errors import MatchError
from movingout.matches.results.results_folder import Shard
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import Journal, owned


def refusing(code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def answer(_descriptor: int, **_options: object) -> bool:
        raise OSError(code, os.strerror(code))

    for name in ("lock_descriptor", "unlock_descriptor"):
        monkeypatch.setattr(file_lock, name, answer)


@pytest.mark.parametrize("code", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP])
def test_journals_and_results_need_no_locks(tmp_path: Path, code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    refusing(code, monkeypatch)
    Journal.create(tmp_path / "one.mcap.journal").close()
    with owned(tmp_path / "one.mcap.journal") as data:
        assert data == b""
    with Shard(tmp_path), Shard(tmp_path):
        pass


def test_a_lock_that_fails_otherwise_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refusing(errno.EIO, monkeypatch)
    with pytest.raises(RecordingError, match="Input/output error"):
        Journal.create(tmp_path / "one.mcap.journal")
    with pytest.raises(MatchError, match=r"cannot lock .*: Input/output error"):
        Shard(tmp_path)


def test_a_file_is_locked_for_others_until_it_is_given_back(tmp_path: Path) -> None:
    with (tmp_path / "file").open("wb") as mine, (tmp_path / "file").open("wb") as other:
        assert file_lock.lock_file(mine.fileno()) and not file_lock.lock_file(other.fileno())
        file_lock.unlock_file(mine.fileno())
        assert file_lock.lock_file(other.fileno())


def test_of_a_file_that_may_only_be_read_it_is_seen_whether_it_is_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really = os.open

    def opened(path: Path, flags: int) -> int:
        if flags & os.O_RDWR:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return really(path, flags)

    with (tmp_path / "file").open("wb") as mine:
        monkeypatch.setattr(os, "open", opened)
        assert not file_lock.is_locked(tmp_path / "file")
        assert file_lock.lock_file(mine.fileno()) and file_lock.is_locked(tmp_path / "file")
