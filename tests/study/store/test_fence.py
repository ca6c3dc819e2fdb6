"""Fencing tokens: of several servers, the newest writes to the databases of a study, and no other."""

import threading
from contextlib import closing

import pytest
from sqlalchemy import make_url

from movingout.study.errors import StoreError, StoreFenced
from movingout.study.store import IdentityStore, Store
from movingout.study.store.database import alone
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.tables import counts


def test_the_newest_server_writes_and_the_one_before_cannot(postgres: str) -> None:
    with closing(Store(postgres, fence=3)) as first:
        freeze_study(first, "s", "its file", {}, {})
        first.arrive("P1", "en")
        with closing(Store(postgres, fence=3)) as same:
            same.arrive("P2", "en")
            first.arrive("P3", "en")
        with closing(Store(postgres, fence=4)) as second:
            with pytest.raises(StoreFenced):
                first.arrive("P4", "en")
            second.arrive("P5", "en")
            assert [one.pid for one in first.everybody()] == ["P1", "P2", "P3", "P5"]
        with pytest.raises(StoreFenced, match="higher fencing token than 3"):
            Store(postgres, fence=3)


def test_who_takes_over_waits_for_a_write_that_has_begun(postgres: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.study.store.database.FENCED_S", 60)  # a busy machine may take seconds for the write
    with closing(Store(postgres, fence=1)) as first:
        with first.database.write() as connection:
            opened: list[Store] = []
            taking = threading.Thread(target=lambda: opened.append(Store(postgres, fence=2)))
            taking.start()
            taking.join(0.3)
            assert opened == []
            connection.exec_driver_sql("INSERT INTO counts (name, number) VALUES ('declined', 1)")
        taking.join(20.0)
        with closing(opened[0]) as second:
            assert second.rows(counts) == [{"name": "declined", "number": 1}]


def test_a_server_that_hangs_within_a_write_does_not_keep_the_next_one_out(
    postgres: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:  # the second one keeps its own time: on a busy machine it needs more
        patch.setattr("movingout.study.store.database.FENCED_S", 1)
        hangs = Store(postgres, fence=1)
    with closing(hangs):
        with pytest.raises(StoreError), hangs.database.write() as connection:
            try:
                with closing(Store(postgres, fence=2)) as second:  # as long as the database gives the first one
                    freeze_study(second, "s", "its file", {}, {})
            except StoreError as error:
                pytest.fail(f"the next one was kept out: {error}")
            connection.exec_driver_sql("INSERT INTO counts (name, number) VALUES ('declined', 1)")
        with pytest.raises(StoreFenced):
            hangs.arrive("P2", "en")


def test_identities_are_fenced_in_a_schema_of_their_own(postgres: str) -> None:
    with closing(Store(postgres, fence=1)) as store, store.database.write() as connection:
        connection.exec_driver_sql("CREATE SCHEMA apart")
    beside = make_url(postgres).update_query_dict({"options": "-csearch_path=apart"}).render_as_string(False)
    with (
        closing(IdentityStore(beside, fence=1)) as first,
        closing(IdentityStore(beside, fence=2)),
        pytest.raises(StoreFenced),
    ):
        first.pid("prolific", "somebody")


@pytest.mark.slow
def test_who_deletes_needs_the_database_alone_and_servers_share_it(postgres: str) -> None:
    with closing(Store(postgres, fence=1)) as first, closing(Store(postgres, fence=2)) as second:
        for server in (first, second):
            server.everybody()
        with pytest.raises(StoreError, match="is being served"), alone(postgres):
            pass
    with alone(postgres), pytest.raises(StoreError, match="is being served"), alone(postgres):
        pass
    with alone(postgres):
        pass
