"""Databases that cannot be used, and what is kept of those that fail meanwhile."""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from movingout.study.errors import StoreError
from movingout.study.store import IdentityStore, Store
from movingout.study.store.database import Database
from tests.study.support import agree, open_store


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("oracle://host/name", "oracle is not supported|cannot"),
        ("not an address", "is not the address of a database"),
        (
            "postgresql://nobody:hidden@127.0.0.1:1/none",
            r"//nobody:\*\*\*@127.0.0.1:1/none refused",
        ),
    ],
)
def test_an_address_that_leads_nowhere_is_one_sentence_without_the_password(address: str, reason: str) -> None:
    with pytest.raises(StoreError, match=reason):
        Store(address)


def test_a_file_that_is_no_database_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "study.sqlite").write_bytes(b"a letter to my aunt" * 100)
    with pytest.raises(StoreError, match="the file is damaged, or no database; bring back the last backup"):
        open_store(tmp_path)


def test_a_database_of_a_newer_version_is_one_sentence_and_stays_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "study.sqlite"
    Database(path, "main").close()
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("UPDATE alembic_version SET version_num = '0999'")
    with pytest.raises(StoreError, match=r"study.sqlite was written by a newer version of this program; use that one"):
        Database(path, "main")
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("SELECT version_num FROM alembic_version").fetchall() == [("0999",)]


def test_a_full_database_refuses_and_keeps_what_was_confirmed(tmp_path: Path) -> None:
    store = open_store(tmp_path)
    agree(store, ["P1"])
    with store.database.write() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
        connection.exec_driver_sql(f"PRAGMA max_page_count={pages}")
    with pytest.raises(StoreError, match="is full; free some space"):
        for _ in range(100):
            store.note("x" * 10_000)
    assert store.has_consented("P1", "1")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_one_sentence(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(StoreError, match="cannot open the database"):
        IdentityStore(tmp_path / "identity.sqlite")


def test_a_database_that_turns_read_only_is_one_sentence(tmp_path: Path) -> None:
    store = open_store(tmp_path)
    with store.database.write() as connection:
        connection.exec_driver_sql("PRAGMA query_only=ON")
    with pytest.raises(StoreError, match="readonly database; make the file and its folder writable"):
        store.note("lost?")


def test_a_commit_is_on_the_disk_before_the_method_returns(tmp_path: Path) -> None:
    store = open_store(tmp_path)
    agree(store, ["P1"])
    with sqlite3.connect(tmp_path / "study.sqlite") as other:
        assert other.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        assert other.execute("SELECT count(*) FROM consents").fetchone() == (1,)
    other.close()
