"""Absences are no minutes here, on SQLite and on PostgreSQL."""

from pathlib import Path

import pytest

from movingout.server.study.earnings import minutes_here
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
    store.seen({"P1": 70, "P2": 80})
    store.seen({"P2": 1_790_000_000_000})
    assert [one.last_seen_ms for one in store.everybody()] == [70, 1_790_000_000_000, None]
