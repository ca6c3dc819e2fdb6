"""LeRobotDataset v3.0, written with pyarrow alone (lerobot itself would bring 8 GB).

The layout is that of lerobot 0.4 (`codebase_version` v3.0): meta/info.json, meta/stats.json, meta/tasks.parquet (a
pandas frame indexed by the task's text), meta/episodes and data as parquet in chunk-000/file-000. docs/exports.md says
how loading in the real library was checked.
"""

import contextlib
import json
from collections import defaultdict
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.feature_statistics import RunningStatistics, feature_statistics, streamed
from movingout.recordings.exports.lerobot_features import VIEW, column_array, divided, features, table_of, tasks_table
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TEST, TRAIN
from movingout.recordings.exports.target import new_target
from movingout.recordings.exports.trajectories import ExportedTrajectory, all_trajectories, headings
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.observation import LAYOUTS

FILE_BYTES = 100_000_000
FILES_PER_CHUNK = 1000
SIDES = range(16, 513, 2)  # of images, in pixels
ROWS_AT_ONCE = 100  # rows about episodes, each of some 20 KB of statistics
FRAMES_AT_ONCE = 4096  # when frames are read again


def write(plan: ExportPlan) -> None:
    """A dataset folder. Training episodes come first, since a LeRobot split is a range of episodes.

    One trajectory at a time is in memory, however many recordings there are. Raises RecordingError.
    """
    if plan.images and plan.images not in SIDES:
        raise RecordingError(f"images have an even number of pixels from 16 to 512, not {plan.images}")
    layout = LAYOUTS.get(plan.layout)
    if layout is not None and layout.picture:
        raise RecordingError(
            f"LeRobot's state is numbers, and {plan.layout} is a picture; take another --layout, and pictures as video "
            f"with --images {layout.picture[0]}"
        )
    plan.check_seen()
    make = partial(_converted, view=plan.view, layout=plan.layout, keep=bool(plan.images))
    with new_target(plan.target) as folder:
        with _Dataset(folder, plan) as dataset:
            for made, episode in plan.converted(make, "exporting", training_first=True):
                for trajectory in made:
                    dataset.add(trajectory, episode)
        if not dataset.episodes:
            raise RecordingError("no ticks in these recordings, so there is nothing to train on")
        _write_json(folder / "meta" / "stats.json", dataset.statistics())
        _write_json(folder / "meta" / "info.json", _info(dataset, plan))
        pq.write_table(tasks_table(list(dataset.tasks)), folder / "meta" / "tasks.parquet", compression="zstd")


def _converted(
    episode: Episode, part: str, view: str, layout: str, keep: bool
) -> tuple[list[ExportedTrajectory], Episode | None]:
    """`keep` keeps the episode, from which images are drawn."""
    return all_trajectories(episode, part, view, layout), episode if keep else None


class _Dataset(contextlib.ExitStack):
    """The tables of a data set while they are written, and totals over all episodes."""

    def __init__(self, folder: Path, plan: ExportPlan) -> None:
        super().__init__()
        self.episodes = self.frames = self.training = 0
        self.tasks: dict[str, int] = {}  # text to number, in order of appearance
        self.moments: defaultdict[str, RunningStatistics] = defaultdict(RunningStatistics)  # by feature
        self.features = features(plan)
        self._view, self._layout = plan.view, plan.layout
        self._data = self.enter_context(_Table(folder / "data"))
        self._about = self.enter_context(_Table(folder / "meta" / "episodes"))
        self._rows: list[dict[str, Any]] = []  # of `_about`, waiting to be written
        self.callback(self._write_rows)
        self._side, self._video = plan.images, None
        if plan.images:
            from movingout.recordings.exports.lerobot_video import VideoFiles

            self._video = self.enter_context(VideoFiles(folder / "videos" / VIEW, plan.images, FILES_PER_CHUNK))

    def add(self, trajectory: ExportedTrajectory, episode: Episode | None) -> None:
        frames = self._frames_of(trajectory)
        chunk, file = self._data.write(table_of(frames, self.features))
        length = len(trajectory.actions)
        self._rows.append(
            {
                "episode_index": self.episodes,
                "tasks": [trajectory.task],
                "length": length,
                "data/chunk_index": chunk,
                "data/file_index": file,
                "dataset_from_index": self.frames,
                "dataset_to_index": self.frames + length,
                "recording": trajectory.episode_id,
                "seat": trajectory.seat,
                **{
                    f"stats/{name}/{key}": value
                    for name, values in frames.items()
                    for key, value in feature_statistics(values).items()
                },
                **self._film(trajectory, episode),
            }
        )
        for name, values in frames.items():
            self.moments[name].add(values)
        self.episodes += 1
        self.frames += length
        self.training += trajectory.split == TRAIN
        if len(self._rows) == ROWS_AT_ONCE:
            self._write_rows()

    def statistics(self) -> dict[str, Any]:
        """Of all frames, by feature; after the end."""
        told: dict[str, Any] = dict(streamed(self.moments, self._stored()))
        return told if self._video is None else {**told, VIEW: self._video.colours.told()}

    def _film(self, trajectory: ExportedTrajectory, episode: Episode | None) -> dict[str, Any]:
        if self._video is None or episode is None:
            return {}
        from movingout.recordings.exports.lerobot_video import views

        return self._video.add(VIEW, views(episode, trajectory.seat, self._side))

    def _stored(self) -> Iterator[dict[str, Any]]:
        """The frames again, some at a time, as arrays by feature."""
        for path in self._data.paths:
            with pq.ParquetFile(path) as file:
                for batch in file.iter_batches(FRAMES_AT_ONCE):
                    yield {name: column_array(batch.column(name), batch.num_rows) for name in self.features}

    def _frames_of(self, trajectory: ExportedTrajectory) -> dict[str, Any]:
        """Every feature as one array over the frames of an episode."""
        steps = np.arange(len(trajectory.actions))
        task = self.tasks.setdefault(trajectory.task, len(self.tasks))
        return {
            **divided(trajectory, self._view, self._layout),
            "action": trajectory.actions,
            "next.reward": trajectory.rewards,
            "next.done": trajectory.dones,
            "timestamp": (steps / TICKS_PER_SECOND).astype(np.float32),
            "frame_index": steps,
            "episode_index": np.full_like(steps, self.episodes),
            "index": self.frames + steps,
            "task_index": np.full_like(steps, task),
        }

    def _write_rows(self) -> None:
        if self._rows:
            chunk, file = self._about.place()
            own = {"meta/episodes/chunk_index": chunk, "meta/episodes/file_index": file}
            self._about.write(pa.Table.from_pylist([{**row, **own} for row in self._rows]))
            self._rows.clear()


class _Table(contextlib.ExitStack):
    """A table that grows, in files of about FILE_BYTES: chunk-000/file-000.parquet and so on."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.paths: list[Path] = []
        self._folder = folder
        self._writer: Any = None
        self._sink: Any = None

    def place(self) -> tuple[int, int]:
        """The chunk and the file that the next rows go to."""
        full = self._sink is None or self._sink.tell() >= FILE_BYTES
        return divmod(len(self.paths) if full else len(self.paths) - 1, FILES_PER_CHUNK)

    def write(self, rows: Any) -> tuple[int, int]:
        """Add rows; where they went."""
        chunk, file = self.place()
        path = self._folder / f"chunk-{chunk:03d}" / f"file-{file:03d}.parquet"
        if path not in self.paths[-1:]:
            self.close()
            path.parent.mkdir(parents=True, exist_ok=True)
            self._sink = self.enter_context(path.open("wb"))
            self._writer = self.enter_context(pq.ParquetWriter(self._sink, rows.schema, compression="zstd"))
            self.paths.append(path)
        self._writer.write_table(rows)
        return chunk, file


def _info(dataset: _Dataset, plan: ExportPlan) -> dict[str, Any]:
    splits = {TRAIN: f"0:{dataset.training}", TEST: f"{dataset.training}:{dataset.episodes}"}
    return {
        "codebase_version": "v3.0",
        "robot_type": "moving_out",
        "total_episodes": dataset.episodes,
        "total_frames": dataset.frames,
        "total_tasks": len(dataset.tasks),
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": FILE_BYTES // 1_000_000,
        "video_files_size_in_mb": 200,
        "fps": TICKS_PER_SECOND,
        "splits": splits if dataset.training < dataset.episodes else {TRAIN: splits[TRAIN]},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4" if plan.images else None,
        "features": dataset.features | _pictures(plan),
        "movingout": {"layout": plan.layout, "view": plan.view, "headings": headings(plan.view, plan.layout)},
    }


def _pictures(plan: ExportPlan) -> dict[str, Any]:
    if not plan.images:
        return {}
    from movingout.recordings.exports.lerobot_video import described

    return {VIEW: described(plan.images)}


def _write_json(path: Path, document: dict[str, Any]) -> None:
    path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
