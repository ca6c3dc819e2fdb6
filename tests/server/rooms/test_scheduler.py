"""The schedule, with a clock that the test turns."""

from dataclasses import dataclass, field

import pytest

from movingout.server.rooms.lateness import Lateness
from movingout.server.rooms.scheduler import EARLY_S, MOST_PER_WAKE, SLOTS, RoomScheduler


@dataclass
class Clock:
    """Stands still until the test moves it."""

    now: float = 100.0

    def __call__(self) -> float:
        return self.now


@dataclass
class Calls:
    """What one room was told."""

    clock: Clock
    ticks: list[tuple[float, int]] = field(default_factory=list)  # due, skipped
    beats: list[float] = field(default_factory=list)

    def tick(self, now: float, due: float, skipped: int) -> None:
        assert now == self.clock.now
        self.ticks.append((round(due, 6), skipped))

    def beat(self) -> None:
        self.beats.append(round(self.clock.now, 6))


def run_until(scheduler: RoomScheduler, clock: Clock, end: float) -> None:
    """Wake exactly when the scheduler asks for it."""
    while True:
        due = scheduler.run_due()
        if due is None or due > end:
            clock.now = end
            return
        clock.now = max(clock.now, due)


def test_a_room_ticks_every_100_ms_and_beats_in_between() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    run_until(scheduler, clock, 100.55)
    assert [due for due, _ in calls.ticks] == [100.0, 100.1, 100.2, 100.3, 100.4, 100.5]
    assert calls.beats == [100.05, 100.15, 100.25, 100.35, 100.45, 100.55]


def test_a_rehearsal_ticks_as_fast_as_it_is_told() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock, tick_s=0.02), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    run_until(scheduler, clock, 100.055)
    assert [due for due, _ in calls.ticks] == [100.0, 100.02, 100.04]
    assert calls.beats == [100.01, 100.03, 100.05]


def test_deadlines_do_not_drift_in_an_hour() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    run_until(scheduler, clock, 100.0 + 3600.0)
    assert len(calls.ticks) == 36_001
    assert calls.ticks[-1][0] == pytest.approx(3700.0, abs=1e-6)


def test_a_late_tick_runs_once_and_the_next_is_on_time() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    scheduler.run_due()
    clock.now = 100.16
    scheduler.run_due()
    run_until(scheduler, clock, 100.35)
    assert calls.ticks == [(100.0, 0), (100.1, 0), (100.2, 0), (100.3, 0)]
    assert scheduler.lateness.max_ms == pytest.approx(60.0)


def test_missed_ticks_are_skipped_and_counted_never_made_up_for() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    scheduler.run_due()
    clock.now = 102.13  # a stop of two seconds
    for _ in range(5):
        scheduler.run_due()
    assert calls.ticks == [(100.0, 0), (102.1, 20)]
    assert scheduler.lateness.skipped == 20


def test_rooms_are_spread_over_the_100_ms() -> None:
    clock = Clock()
    scheduler = RoomScheduler(clock)
    rooms = [Calls(clock) for _ in range(2 * SLOTS)]
    for calls in rooms:
        scheduler.add(calls.tick, calls.beat)
    run_until(scheduler, clock, 100.2)
    phases = sorted(round(calls.ticks[-1][0] % 0.1, 3) for calls in rooms)
    assert all(phases.count(phase) == 2 for phase in phases)


def test_a_crowd_of_due_rooms_gives_the_sockets_a_turn_in_between() -> None:
    clock = Clock()
    scheduler = RoomScheduler(clock)
    rooms = [Calls(clock) for _ in range(3 * MOST_PER_WAKE)]
    for calls in rooms:
        scheduler.add(calls.tick, calls.beat)
    clock.now = 100.2
    scheduler.run_due()
    assert sum(len(calls.ticks) for calls in rooms) == MOST_PER_WAKE


def test_a_timer_that_fires_a_little_early_does_not_spin() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    scheduler.add(calls.tick, calls.beat)
    scheduler.run_due()
    clock.now = 100.05
    scheduler.run_due()
    clock.now = 100.1 - 0.9 * EARLY_S
    scheduler.run_due()
    assert [due for due, _ in calls.ticks] == [100.0, 100.1]
    assert scheduler.lateness.max_ms == 0.0


def test_a_removed_room_is_never_called_again() -> None:
    clock = Clock()
    scheduler, calls = RoomScheduler(clock), Calls(clock)
    entry = scheduler.add(calls.tick, calls.beat)
    scheduler.run_due()
    scheduler.remove(entry)
    scheduler.remove(entry)
    run_until(scheduler, clock, 101.0)
    assert len(calls.ticks) == 1 and calls.beats == []


def test_percentiles_are_exact_to_a_twentieth_of_a_millisecond() -> None:
    lateness = Lateness()
    for late in range(1000):
        lateness.add(late / 100, 0)  # 0 to 9.99 ms
    assert lateness.report() == {"p50": 5.0, "p99": 9.9, "p999": 9.99, "max": 9.99}
    lateness.clear()
    assert lateness.report() == {"p50": 0.0, "p99": 0.0, "p999": 0.0, "max": 0.0}
