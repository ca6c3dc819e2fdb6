"""Trails and heat maps, as arrays."""

from pathlib import Path

import numpy as np

from movingout.recordings import read_episode
from movingout.recordings.occupancy import CELLS, heat_picture, occupancy, shades, smoothed
from movingout.recordings.viewer.trails import trail
from tests.recordings.viewer.support import recorded


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
