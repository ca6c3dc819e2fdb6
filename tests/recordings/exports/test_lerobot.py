"""A LeRobot data set of any size: one trajectory at a time is in memory, and files stay of a bounded size."""

import gc
import json
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
import pyarrow.parquet as pq
import pytest

from movingout.recordings import RecordingError, finalise, read_episode
from movingout.recordings.exports import export, lerobot
from movingout.recordings.exports.feature_statistics import feature_statistics
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.trajectories import ExportedTrajectory, trajectories
from movingout.world.raster import pixels
from tests.recordings.support import record

EPISODES, TICKS = 7, 5


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("recordings")
    return [
        finalise(record(folder, TICKS, episode_id=f"e{number}", seed=number, map_name=map_name)[0])
        for number, map_name in zip(range(EPISODES), ["HandOff", "LeftRight"] * EPISODES, strict=False)
    ]


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """All files of a table, one after the other."""
    return [row for path in sorted(folder.rglob("*.parquet")) for row in pq.read_table(path).to_pylist()]


@pytest.mark.slow
def test_no_more_than_the_episode_at_hand_and_the_one_before_are_in_memory(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[weakref.ref[Any]] = []
    alive: list[int] = []

    def watched(*arguments: Any) -> Iterator[ExportedTrajectory]:
        for trajectory in trajectories(*arguments):
            gc.collect()
            alive.append(sum(one() is not None for one in seen))
            seen.append(weakref.ref(trajectory.observations))
            yield trajectory

    monkeypatch.setattr("movingout.recordings.exports.trajectories.trajectories", watched)
    export("lerobot", ExportPlan(recordings, tmp_path / "dataset"))
    assert len(alive) == 2 * EPISODES and max(alive) <= 3


def test_a_file_that_is_full_is_followed_by_another_and_episodes_say_where_they_are(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lerobot, "FILE_BYTES", 1)
    monkeypatch.setattr(lerobot, "FILES_PER_CHUNK", 3)
    monkeypatch.setattr(lerobot, "ROWS_AT_ONCE", 4)
    folder = tmp_path / "dataset"
    export("lerobot", ExportPlan(recordings, folder))
    episodes = rows_of(folder / "meta" / "episodes")
    assert [row["episode_index"] for row in episodes] == list(range(2 * EPISODES))
    for row in episodes:
        place = f"chunk-{row['data/chunk_index']:03d}/file-{row['data/file_index']:03d}.parquet"
        frames = pq.read_table(folder / "data" / place)
        assert set(frames["episode_index"].to_pylist()) == {row["episode_index"]}
        about = f"chunk-{row['meta/episodes/chunk_index']:03d}/file-{row['meta/episodes/file_index']:03d}.parquet"
        assert row["episode_index"] in pq.read_table(folder / "meta" / "episodes" / about)["episode_index"].to_pylist()
    assert len(list((folder / "data").rglob("*.parquet"))) == 2 * EPISODES
    assert len(list((folder / "meta" / "episodes").rglob("*.parquet"))) == 4


def test_the_statistics_are_those_of_all_frames(recordings: list[Path], tmp_path: Path) -> None:
    folder = tmp_path / "dataset"
    export("lerobot", ExportPlan(recordings, folder))
    told = json.loads((folder / "meta" / "stats.json").read_text())
    frames = rows_of(folder / "data")
    for name in json.loads((folder / "meta" / "info.json").read_text())["features"]:
        whole = feature_statistics(np.array([row[name] for row in frames]))
        for key in ("min", "max", "mean", "std", "count"):
            np.testing.assert_allclose(told[name][key], whole[key], rtol=1e-6, atol=1e-9, err_msg=f"{name} {key}")
    assert told["frame_index"]["q50"] == [2.0] and told["next.done"]["q99"] == [0.0]


def test_tasks_are_numbered_as_they_appear(recordings: list[Path], tmp_path: Path) -> None:
    folder = tmp_path / "dataset"
    export("lerobot", ExportPlan(recordings, folder))
    tasks = pq.read_table(folder / "meta" / "tasks.parquet").to_pylist()
    assert [row["task_index"] for row in tasks] == [0, 1]
    numbers = {row["episode_index"]: row["task_index"] for row in rows_of(folder / "data")}
    for row in rows_of(folder / "meta" / "episodes"):
        assert tasks[numbers[row["episode_index"]]]["__index_level_0__"] == row["tasks"][0]


def test_the_layout_is_divided_into_the_robot_and_everything_else(recordings: list[Path], tmp_path: Path) -> None:
    folder = tmp_path / "dataset"
    export("lerobot", ExportPlan(recordings[:1], folder, layout="map-v1"))
    info = json.loads((folder / "meta" / "info.json").read_text())
    own, rest = (info["features"][f"observation.{name}"] for name in ("state", "environment_state"))
    assert (own["shape"], rest["shape"]) == ([8], [161])
    assert own["names"][0] == "map-v1_0" and rest["names"][0] == "map-v1_8"
    assert info["movingout"] == {"layout": "map-v1", "view": "ego", "headings": "arena"}
    first = next(trajectories(read_episode(recordings[0]), "train", "ego", "map-v1"))
    frame = rows_of(folder / "data")[0]
    whole = [*frame["observation.state"], *frame["observation.environment_state"]]
    assert np.array_equal(np.array(whole, dtype=np.float32), first.observations[0])


def test_images_are_a_video_with_a_frame_per_tick(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from movingout.recordings.exports import lerobot_video

    monkeypatch.setattr(lerobot_video, "VIDEO_BYTES", 1)
    folder = tmp_path / "dataset"
    export("lerobot", ExportPlan(recordings[:2], folder, images=64))
    key = "observation.images.view"
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert info["features"][key]["shape"] == [64, 64, 3] and info["features"][key]["dtype"] == "video"
    for number, row in enumerate(rows_of(folder / "meta" / "episodes")):
        place = info["video_path"].format(video_key=key, chunk_index=0, file_index=row[f"videos/{key}/file_index"])
        with av.open(str(folder / place)) as video:
            shown = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
        assert len(shown) == TICKS and row[f"videos/{key}/to_timestamp"] == TICKS / 10
        episode = read_episode(recordings[number // 2])
        for picture, state in zip(shown, episode.states, strict=False):
            apart = picture.astype(int) - pixels(episode.header.map, state, number % 2, 64)
            assert np.abs(apart).mean() < 6
        assert np.array(row[f"stats/{key}/mean"]).shape == (3, 1, 1)
    told = json.loads((folder / "meta" / "stats.json").read_text())[key]
    assert told["count"] == [4 * TICKS] and 0 < told["mean"][0][0][0] < 1
    with pytest.raises(RecordingError, match=r"image-v1 is a picture; take another --layout, and .* --images 128"):
        export("lerobot", ExportPlan(recordings[:1], tmp_path / "x", layout="image-v1"))
    with pytest.raises(RecordingError, match="an even number of pixels from 16 to 512, not 97"):
        export("lerobot", ExportPlan(recordings[:1], tmp_path / "x", images=97))
