"""What is drawn over the bodies, as arrays."""

from pathlib import Path

import numpy as np

from recordings import AgentDecision, read_episode
from recordings.occupancy import CELLS, heat_picture, occupancy, shades, smoothed
from recordings.viewer.overlays import CHOSEN_RGB, Decisions, candidate_lines, trail
from tests.recordings.viewer.support import recorded


def decision(tick: int, *scores: float, chosen: int = 0) -> AgentDecision:
    found = [{"score": score, "terms": [], "x": [0.0, score], "y": [0.0, 1.0]} for score in scores]
    return AgentDecision(tick, 1, 1.0, False, {"chosen": chosen, "candidates": found})


def test_occupancy_adds_up_to_the_time_played_and_finds_the_corner(tmp_path: Path) -> None:
    episode = read_episode(recorded(tmp_path))
    grid = occupancy(episode.states, 0)
    assert grid.shape == (CELLS, CELLS)
    assert np.isclose(grid.sum(), 0.1 * len(episode.ticks))
    x, y = episode.states[-1].robot_poses[0, :2]
    assert grid[int((y + 1.2) / 0.05), int((x + 1.2) / 0.05)] > 0.0


def test_smoothing_keeps_the_sum_and_shades_end_at_one() -> None:
    grid = np.zeros((8, 8))
    grid[3, 4] = 16.0
    soft = smoothed(grid)
    assert soft.sum() == 16.0 and soft[3, 4] == 4.0 and soft[2, 3] == 1.0
    assert shades(soft).max() == 1.0
    assert shades(np.zeros((2, 2))).max() == 0.0


def test_a_heat_picture_has_the_top_row_first_and_the_colour_of_the_seat() -> None:
    grids = (np.zeros((4, 4)), np.zeros((4, 4)))
    grids[0][3, 0] = 1.0  # blue at the top left
    picture = heat_picture(grids, (0, 1), pixels=8)
    assert picture.shape == (32, 32, 4)
    red, _, blue, alpha = picture[0, 0].tolist()
    assert blue > red and alpha > 200
    assert picture[16, 16, 3] == 0


def test_a_trail_at_the_start_is_a_point(tmp_path: Path) -> None:
    states = read_episode(recorded(tmp_path)).states
    assert trail(states, 0, 0, 50).shape == (1, 2, 3)
    assert trail(states, 0, 20, 50).shape == (20, 2, 3)
    assert trail(states, 0, 20, 5).shape == (5, 2, 3)


def test_decisions_last_until_the_next_one_of_the_same_seat() -> None:
    decisions = Decisions([decision(5, 0.1), AgentDecision(8, 1, 1.0, False), decision(9, 0.2, 0.3)], seat=1)
    assert [len(decisions.at(tick)) for tick in (4, 5, 8, 9, 400)] == [0, 1, 1, 2, 2]
    assert Decisions([decision(5, 0.1)], seat=0).at(50) == []


def test_candidate_lines_are_coloured_by_score_and_the_chosen_one_is_violet_and_higher() -> None:
    considered = Decisions([decision(0, 0.0, 1.0, 0.5, chosen=2)], seat=1).at(0)
    points, colours = candidate_lines(considered)
    assert points.shape == colours.shape == (3, 2, 3)
    assert (colours[2] == CHOSEN_RGB).all()
    assert points[2, 0, 2] > points[1, 0, 2]
    assert not np.allclose(colours[0], colours[1])


def test_no_candidates_are_no_lines() -> None:
    points, colours = candidate_lines([])
    assert points.shape == colours.shape == (0, 2, 3)
