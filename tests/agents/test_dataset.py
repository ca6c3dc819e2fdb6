"""Windows over recordings: what they hold, and that nobody is in two splits."""

from pathlib import Path

import numpy as np
import pytest

from agents.dataset import data_hash, read_trajectories, recording_files, trajectory_windows
from agents.errors import DataError
from tests.agents.learning import recorded, walked


def test_a_window_repeats_the_first_observation_and_the_last_action_and_never_leaves_its_episode() -> None:
    walks = [walked(ticks=20, seed=1, people=("a", "b")), walked(ticks=30, seed=2, people=("c", "a"))]
    windows = trajectory_windows(walks, "official-v1", "hold")
    assert len(windows) == 2 * (20 + 30)
    first_of_second_seat = np.array([20])
    seen = windows.observations(first_of_second_seat, 3)[0]
    assert np.array_equal(seen, np.repeat(windows.features[20:21], 3, axis=0))
    chunk = windows.chunks(np.array([18]), 4)[0]
    assert np.array_equal(chunk, windows.targets[[18, 19, 19, 19]])


def test_targets_are_the_actions_and_the_level_of_the_hand_after_each_tick() -> None:
    walk = walked(ticks=60, seed=5)
    targets = walk.targets(1, "hold")
    assert np.allclose(targets[:, 0], walk.actions[:, 1, 0], atol=1e-6)
    assert np.allclose(
        np.arctan2(targets[:, 2], targets[:, 1]), np.angle(np.exp(1j * walk.actions[:, 1, 1])), atol=1e-5
    )
    assert np.array_equal(targets[:, 4] > 0, walk.held[1:, 1] >= 0)
    assert np.array_equal(targets[:, 3], -targets[:, 4])


def test_no_participant_is_in_training_and_validation() -> None:
    walks = [walked(ticks=5, seed=n, people=(f"p{n}", f"q{n}")) for n in range(6)]
    windows = trajectory_windows(walks, "official-v1", "hold")
    train, held_out = windows.split(0.25, seed=1)
    assert len(train) + len(held_out) == len(windows)
    assert len(set(windows.people[held_out])) == 3
    assert not set(windows.people[train]) & set(windows.people[held_out])


def test_recordings_are_read_back_as_they_were_played(tmp_path: Path) -> None:
    file = recorded(tmp_path, "one", ticks=25, seed=4, people=("ann", "bob"))
    (read,) = read_trajectories(recording_files([tmp_path]))
    walk = walked(ticks=25, seed=4)
    assert read.participants == ("ann", "bob")
    for name in ("robot_poses", "robot_velocities", "held", "item_poses", "actions"):
        assert np.array_equal(getattr(read, name), getattr(walk, name)), name
    assert data_hash([file]) == data_hash([file]) != data_hash([recorded(tmp_path, "two", ticks=25, seed=5)])


def test_a_folder_without_recordings_is_answered_with_the_command_that_makes_some(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="movingout demos generate"):
        recording_files([tmp_path])
    with pytest.raises(DataError, match="no recording at"):
        recording_files([tmp_path / "gone.mcap"])
