"""Absences are no minutes here, on SQLite and on PostgreSQL."""

from contextlib import closing
from pathlib import Path

import pytest
from alembic import command
from sqlalchemy import create_engine

from movingout.server.study.earnings import minutes_here
from movingout.study.store import Store
from movingout.study.store.database import alembic_config
from tests.study.support import Clock, agree, open_store


def test_who_is_away_at_the_end_was_here_until_they_were_last_seen(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1", "P2"])
    clock.ms += 86_400_000
    store.finish("P1", "dropped-out", "AB", away_s=86_000.0)
    store.finish("P2", "dropped-out", "CD", away_s=1e9)
    minutes = [minutes_here(store.participant(pid)) for pid in ("P1", "P2")]
    assert minutes == [pytest.approx(400 / 60, abs=0.1), 0.0]


def test_absences_before_somebody_came_back_add_up_and_are_no_minutes_here(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1"])
    for hours in (10, 14):
        store.was_away("P1", hours * 3600.0)
    clock.ms += 25 * 3_600_000
    store.finish("P1", "done", "AB")
    assert minutes_here(store.participant("P1")) == pytest.approx(60, abs=0.1)


def test_it_is_known_when_participants_were_last_seen(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2", "P3"])
    store.seen({"P1": 70, "P2": 80}, {"P1"})
    heard_ms = store.participant("P1").heard_ms
    store.seen({"P1": 90, "P2": 1_790_000_000_000})
    assert [one.last_seen_ms for one in store.everybody()] == [90, 1_790_000_000_000, None]
    assert heard_ms and [one.heard_ms for one in store.everybody()] == [heard_ms, None, None], "no pause moves it"


def test_who_was_heard_before_the_clock_was_set_back_was_heard_earlier(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2"])
    store.seen({"P1": 80}, {"P1"})
    heard_ms = store.participant("P1").heard_ms
    store.set_back({"P1": 1000, "P2": 1000})
    assert heard_ms and [one.heard_ms for one in store.everybody()] == [heard_ms - 1000, None]


def test_data_of_before_have_when_somebody_was_last_seen(tmp_path: Path) -> None:
    path = tmp_path / "study.sqlite"
    engine = create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        command.upgrade(alembic_config("main", connection), "0006")
        for pid, seen in (("P1", "9"), ("P2", "NULL")):
            connection.exec_driver_sql(
                "INSERT INTO participants (pid, member, language, step, arrived_ms, last_seen_ms)"
                f" VALUES ('{pid}', 0, 'en', 'form', 7, {seen})"
            )
    engine.dispose()
    with closing(Store(path)) as store:
        assert [one.heard_ms for one in store.everybody()] == [9, None]
