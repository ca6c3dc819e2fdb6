"""What was deleted is overwritten, and counts as overwritten only when it is."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from movingout.study.data.erasure import purge
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StoreError, StoreLocked
from movingout.study.store import database
from movingout.study.store.database import Database
from movingout.study.store.removal import remove_participant
from tests.study.support import agree, open_identities, open_store, study

SECRET = "SECRETID123"


def is_in_files(folder: Path) -> bool:
    return any(SECRET.encode() in path.read_bytes() for path in folder.glob("identity.sqlite*"))


def test_what_another_program_reads_counts_as_deleted_only_when_it_is_overwritten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database, "BUSY_S", 0.05)
    identities = open_identities(tmp_path)
    pid, _ = identities.pid("prolific", SECRET)
    with closing(sqlite3.connect(tmp_path / "identity.sqlite", isolation_level=None)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT * FROM identities").fetchall()
        identities.drop([pid])
        with pytest.raises(StoreError, match=r"is still in .*another program reads it") as told:
            identities.database.scrub()
        assert not isinstance(told.value, StoreLocked), "who waits behind it can write"
        assert is_in_files(tmp_path) and identities.database.is_unscrubbed()
        identities.pid("prolific", "5f3c")
    identities.database.scrub()
    assert not is_in_files(tmp_path) and not identities.database.is_unscrubbed()


def test_a_deletion_that_ends_before_it_is_overwritten_is_so_by_the_next_purge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = StudyFolder(study(), tmp_path)
    store, identities = open_store(folder.own), open_identities(folder.own)
    pid, _ = identities.pid("prolific", SECRET)
    agree(store, [pid])

    def stopped(database: Database) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Database, "scrub", stopped)
        with pytest.raises(KeyboardInterrupt):
            identities.forget(pid)
        with pytest.raises(KeyboardInterrupt):
            remove_participant(store, pid, 0)
    databases = (store.database, identities.database)
    assert [one.is_unscrubbed() for one in databases] == [True, True]
    purge(folder, store)
    assert [one.is_unscrubbed() for one in databases] == [False, False] and not is_in_files(folder.own)
