"""Pings in recordings: where they pointed, and what the partner did then."""

import math
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import Event, finalise, read_episode
from movingout.recordings.pings import NEAR, ping_outcomes
from movingout.world.ping import OWN_PLACE
from tests.recordings.support import begin, play, play_tick


def test_a_ping_points_at_where_robot_and_item_were_when_it_was_said(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 7)
    state = played.world.state()
    writer.event(Event(8, "ping", seat=1))
    writer.event(Event(8, "ping", seat=0, item=3))
    play(writer, played, 3)
    pings = [outcome.ping for outcome in ping_outcomes(read_episode(finalise(writer.close("time"))))]
    assert [(ping.tick, ping.seat, ping.item) for ping in pings] == [(8, 1, OWN_PLACE), (8, 0, 3)]
    assert [(ping.x, ping.y) for ping in pings] == [
        tuple(state.robot_poses[1, :2].tolist()),
        tuple(state.item_poses[3, :2].tolist()),
    ]


@pytest.mark.parametrize(("ticks", "came_s"), [(60, "near"), (4, None)])
def test_what_followed_is_when_the_partner_came_near(tmp_path: Path, ticks: int, came_s: str | None) -> None:
    writer, played = begin(tmp_path)  # HandOff: blue above red, one unit apart
    writer.event(Event(1, "ping", seat=0))
    distances = []
    for _ in range(ticks):
        poses = played.world.state().robot_poses
        distances.append(math.dist(poses[0, :2], poses[1, :2]))
        played.random = _Towards(heading=0.0)  # type: ignore[assignment]
        play_tick(writer, played)
    (outcome,) = ping_outcomes(read_episode(finalise(writer.close("time"))))
    assert not outcome.was_near
    if came_s is None:
        assert outcome.came_s is None
    else:
        first = next(tick for tick, gap in enumerate(distances) if gap < NEAR)
        assert outcome.came_s == pytest.approx(first / 10)


class _Towards:
    """Instead of random numbers: red drives at full speed, blue stays."""

    def __init__(self, heading: float) -> None:
        self.heading = heading

    def random(self, size: int) -> "np.typing.NDArray[np.float64]":
        return np.ones(size)  # no grasp

    def uniform(self, low: float, high: float, size: int) -> "np.typing.NDArray[np.float64]":
        return np.array([0.0, 1.0]) if high == 1 else np.array([0.0, self.heading])


def test_a_recording_from_before_there_were_pings_has_none(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 10)
    assert ping_outcomes(read_episode(finalise(writer.close("time")))) == []
