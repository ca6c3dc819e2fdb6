"""What is exported as training data can be played in the environments with the same layout."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")

import json

from movingout.recordings import finalise, read_episode
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.trajectories import trajectories
from movingout.world.action import turned
from movingout.world.env import MovingOutEnv
from tests.recordings.support import record

TICKS = 14


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finalise(record(tmp_path_factory.mktemp("recordings"), ticks=TICKS, map_name="FourCorners")[0])


@pytest.mark.parametrize("layout", ["official-v1", "relative-v1"])
def test_exported_actions_lead_to_the_exported_observations(layout: str, recording: Path) -> None:
    """With `relative-v1`, observations were in the own frame and actions in the arena's."""
    blue, red = trajectories(read_episode(recording), "train", "ego", layout)
    env = MovingOutEnv("FourCorners", layout=layout)
    env.reset()
    for tick in range(TICKS):
        seen, *_ = env.step({"blue": blue.actions[tick], "red": red.actions[tick]})
        np.testing.assert_allclose(seen["blue"], blue.observations[tick + 1], atol=1e-4)
        np.testing.assert_allclose(seen["red"], red.observations[tick + 1], atol=1e-4)


def test_a_joint_view_in_the_own_frame_has_both_headings_in_that_of_blue(recording: Path) -> None:
    episode = read_episode(recording)
    (both,) = trajectories(episode, "train", "joint", "relative-v1")
    (arena,) = trajectories(episode, "train", "joint", "official-v1")
    angles = np.array([state.robot_poses[0, 2] for state in episode.states[:-1]])
    for part in (slice(0, 4), slice(4, 8)):
        np.testing.assert_allclose(turned(both.actions[:, part], angles), arena.actions[:, part], atol=1e-6)


def test_files_say_what_headings_are_relative_to(recording: Path, tmp_path: Path) -> None:
    for name, headings in (("relative-v1", "own"), ("map-v1", "arena")):
        folder = tmp_path / name
        folder.mkdir()
        for kind in ("lerobot", "robomimic", "parquet"):
            export(kind, ExportPlan([recording], folder / kind, layout=name))
        info = json.loads((folder / "lerobot" / "meta" / "info.json").read_text())
        assert info["movingout"]["headings"] == headings
        assert ("relative to the robot's own" in (folder / "lerobot" / "README.md").read_text()) == (headings == "own")
        with h5py.File(folder / "robomimic") as file:
            assert json.loads(file["data"].attrs["env_args"])["movingout"]["headings"] == headings
        export("lerobot", ExportPlan([recording], folder / "joint", layout=name, view="joint"))
        export("robomimic", ExportPlan([recording], folder / "both", layout=name, view="joint"))
        both = "blue" if headings == "own" else headings
        info = json.loads((folder / "joint" / "meta" / "info.json").read_text())
        assert info["movingout"] == {"layout": name, "view": "joint", "headings": both}
        with h5py.File(folder / "both") as file:
            assert json.loads(file["data"].attrs["env_args"])["movingout"]["headings"] == both
        field = pq.read_schema(folder / "parquet" / "ticks.parquet").field("red_observation")
        assert (b"relative to the own angle" in field.metadata[b"meaning"]) == (headings == "own")
