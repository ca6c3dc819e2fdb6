"""Episodes as arrays: clearances, stretches, waiting."""

import math
from pathlib import Path

import numpy as np
import pytest

from movingout.maps.spec import ItemSpec, Pose
from movingout.recordings import read_episode
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.report.facts import consistency_per_second
from movingout.recordings.report.track import Span, Track, clearance, spans
from movingout.recordings.report.waiting import Wait, waits
from tests.recordings.report.support import still
from tests.recordings.support import record


def test_clearance_is_the_distance_to_the_surface_in_the_items_own_pose() -> None:
    side = math.sqrt(math.pi) * 0.1
    square = ItemSpec(0, "square", "small", 0.1, 1.0, Pose(0.0, 0.0, 0.0))
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, math.pi / 4], [0.0, 0.0, 0.0]])
    points = np.array([[0.5, 0.0], [1.5, 0.5], [0.0, -side / 2]])
    skin = 0.01 * side  # the solid square exceeds its outline by its corner radius
    expected = [0.5 - side / 2 - skin, 0.5 - side / math.sqrt(2) - skin, 0.0]
    assert clearance(square, poses, points).tolist() == pytest.approx(expected)


def test_clearance_of_a_circle_is_never_negative() -> None:
    disc = ItemSpec(0, "circle", "small", 0.1, 1.0, Pose(0.0, 0.0, 0.0))
    assert clearance(disc, np.zeros((2, 3)), np.array([[0.3, 0.4], [0.05, 0.0]])).tolist() == pytest.approx([0.4, 0.0])


def test_spans_join_over_gaps_and_drop_what_is_short() -> None:
    mask = np.array([1, 1, 0, 1, 0, 0, 0, 1], dtype=bool)
    assert list(spans(mask)) == [(0, 2), (3, 4), (7, 8)]
    assert list(spans(mask, gap=1)) == [(0, 4), (7, 8)]
    assert list(spans(mask, at_least=4, gap=1)) == [Span(0, 4)]
    assert list(spans(np.zeros(3, dtype=bool))) == []


def test_waiting_is_one_stretch_per_seat_and_item_and_ends_where_help_takes_hold() -> None:
    track = still(60)
    track.held[10:30, 0] = 1
    track.held[25:40, 1] = 1
    assert waits(track) == [Wait(0, 1, 10, 25), Wait(1, 1, 30, 40)]


def test_holding_a_small_or_a_delivered_item_is_no_waiting() -> None:
    track = still(60)
    track.held[10:30, 0] = 0
    track.held[10:30, 1] = 1
    track.delivered[15:, 1] = True
    assert waits(track) == [Wait(1, 1, 10, 15)]


@pytest.mark.parametrize("seed", range(3))
def test_waiting_adds_up_to_the_metric_of_the_episode(tmp_path: Path, seed: int) -> None:
    journal, _ = record(tmp_path, 400, map_name="FourCorners", seed=seed)
    episode = read_episode(journal)
    total = sum(wait.seconds for wait in waits(Track.of(episode)))
    assert total == pytest.approx(result(episode)["wt_s"])


def test_consistency_per_second_holds_the_terms_of_ac() -> None:
    track = still(25)
    track.held[5:, :] = 1
    track.robots[:, 0, :2], track.robots[:, 1, :2] = (0.0, 0.0), (0.0, 1.0)
    actions = np.zeros((25, 2, 3))
    actions[:, :, 0] = 1.0  # both push along +y, which is the line between them
    actions[15:, 1, 0] = -1.0  # then against each other
    assert consistency_per_second(track, actions).tolist() == [[5.0, 5.0], [5.0, 10.0], [0.0, 5.0]]
