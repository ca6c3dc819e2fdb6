"""What a study keeps of how well a round was played and served."""

import numpy as np

from movingout.server.rooms.rounds.quality import RoundQuality

STILL, MOVING, GRASPING = (0.0, 0.0, 0.0), (0.5, 1.0, 0.0), (0.0, 0.0, 1.0)


def test_a_round_that_has_not_begun_says_nothing() -> None:
    health = RoundQuality()
    assert (health.late_p99_ms(), health.rtt_ms(0), health.idle_share(0), health.hidden_s(0)) == (None, None, None, 0.0)


def test_idle_is_neither_moving_nor_grasping() -> None:
    health = RoundQuality()
    for blue, red in ((STILL, MOVING), (GRASPING, MOVING), (STILL, STILL), (STILL, MOVING)):
        health.tick(np.array([blue, red]), (-1.0, -1.0), 0.0)
    assert (health.idle_share(0), health.idle_share(1)) == (0.75, 0.25)


def test_round_trips_that_were_not_measured_do_not_count() -> None:
    health = RoundQuality()
    for rtt_ms in (-1.0, 20.0, 30.0, 100.0):
        health.tick(np.array([STILL, STILL]), (rtt_ms, -1.0), 0.0)
    assert (health.rtt_ms(0), health.rtt_ms(1)) == (30.0, None)


def test_a_hundred_ticks_have_one_that_is_later_than_the_99th_percentile() -> None:
    health = RoundQuality()
    for late_ms in range(100):
        health.tick(np.array([STILL, STILL]), (-1.0, -1.0), float(late_ms))
    assert health.late_p99_ms() == 99.0


def test_hidden_time_is_counted_in_ticks_of_that_seat() -> None:
    health = RoundQuality()
    for visible in (True, False, False, True):
        health.focus(1, visible)
        health.tick(np.array([STILL, STILL]), (-1.0, -1.0), 0.0)
    assert (health.hidden_s(0), health.hidden_s(1)) == (0.0, 0.2)
