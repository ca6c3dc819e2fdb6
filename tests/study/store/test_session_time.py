"""How long sessions and blocks last, over pauses, nights and clocks that are put right."""

import time
from pathlib import Path

import pytest

from movingout.study.store.clock import now_ms
from movingout.study.store.rounds import PlayerOutcome, Rounds
from movingout.study.store.tables import rounds
from tests.study.support import PLAYED, Clock, agree, open_store, rounds_of


def test_a_clock_that_is_put_right_does_not_make_a_session_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    before = now_ms()
    assert abs(before - time.time_ns() // 1_000_000) < 60_000
    monkeypatch.setattr(time, "time_ns", lambda: 0)
    monkeypatch.setattr(time, "time", lambda: 0.0)
    assert 0 <= now_ms() - before < 60_000


def test_a_block_lasts_from_its_first_round_to_the_end_of_the_newest(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1"])
    unit, played = store.form_unit(["P1"]), Rounds(store)
    first, second, third = rounds_of(unit.slot)[:3]
    for episode, step, seconds in (("e1", first, 30), ("e2", second, 20)):
        played.begin(unit, step, episode, [PlayerOutcome("P1", 0, "keyboard")])
        clock.ms += seconds * 1000
        played.end(episode, PLAYED)
    played.begin(unit, third, "e3", [PlayerOutcome("P1", 0, "keyboard")])
    assert played.block_seconds(unit.id) == {first.block: pytest.approx(50, abs=0.1)}


def test_a_pause_or_a_night_takes_five_minutes_of_a_block(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1"])
    unit, played = store.form_unit(["P1"]), Rounds(store)
    first, second = rounds_of(unit.slot)[:2]
    played.begin(unit, first, "e1", [PlayerOutcome("P1", 0, "keyboard")])
    clock.ms += 3_600_000  # a pause within the round
    played.end("e1", PLAYED)
    clock.ms += 86_400_000  # a night
    played.begin(unit, second, "e2", [PlayerOutcome("P1", 0, "keyboard")])
    clock.ms += 3 * 86_400_000  # the server was killed, and started again after the weekend
    played.end("e2", PLAYED, recovered=True)
    rows = {row["episode"]: row for row in store.rows(rounds)}
    ticks_s = PLAYED.ticks / 10
    assert rows["e2"]["ended_ms"] - rows["e2"]["started_ms"] == pytest.approx(1e3 * (ticks_s + 10), abs=1)
    lasted = (300 + ticks_s) + 300 + (ticks_s + 10)
    assert played.block_seconds(unit.id) == {first.block: pytest.approx(lasted, abs=0.1)}


def test_a_clock_that_is_set_back_takes_nothing_of_a_block(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1"])
    unit, played = store.form_unit(["P1"]), Rounds(store)
    steps = rounds_of(unit.slot)[:3]
    for number, step in enumerate(steps):
        if number == 2:
            clock.ms -= 2 * 3_600_000  # between two runs of the server
        played.begin(unit, step, f"e{number}", [PlayerOutcome("P1", 0, "keyboard")])
        clock.ms += 60_000
        played.end(f"e{number}", PLAYED)
    assert played.block_seconds(unit.id) == {steps[0].block: pytest.approx(180, abs=0.1)}
