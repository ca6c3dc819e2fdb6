"""LeRobotDataset v3.0, written with pyarrow alone (lerobot itself would bring 8 GB).

The layout is that of lerobot 0.4 (`codebase_version` v3.0): meta/info.json, meta/stats.json, meta/tasks.parquet (a
pandas frame indexed by the task's text), meta/episodes and data as parquet in chunk-000/file-000. docs/exports.md says
how loading in the real library was checked.
"""

import contextlib
import json
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.feature_statistics import RunningStatistics, feature_statistics, streamed
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TEST, TRAIN
from movingout.recordings.exports.target import new_target
from movingout.recordings.exports.trajectories import ExportedTrajectory, action_names, trajectories
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.observation import LAYOUTS

FILE_BYTES = 100_000_000
FILES_PER_CHUNK = 1000
ROWS_AT_ONCE = 100  # rows about episodes, each of some 20 KB of statistics
FRAMES_AT_ONCE = 4096  # when frames are read again


def write(plan: ExportPlan) -> None:
    """A dataset folder. Training episodes come first, since a LeRobot split is a range of episodes.

    One trajectory at a time is in memory, however many recordings there are.
    """
    with new_target(plan.target) as folder:
        with _Dataset(folder, plan) as dataset:
            for episode, part in plan.episodes("exporting", training_first=True):
                for trajectory in trajectories(episode, part, plan.view, plan.layout):
                    dataset.add(trajectory)
        if not dataset.episodes:
            raise RecordingError("no ticks in these recordings, so there is nothing to train on")
        _write_json(folder / "meta" / "stats.json", streamed(dataset.moments, dataset.stored()))
        _write_json(folder / "meta" / "info.json", _info(dataset, plan))
        pq.write_table(_tasks(list(dataset.tasks)), folder / "meta" / "tasks.parquet", compression="zstd")


class _Dataset(contextlib.ExitStack):
    """The tables of a data set while they are written, and totals over all episodes."""

    def __init__(self, folder: Path, plan: ExportPlan) -> None:
        super().__init__()
        self.episodes = self.frames = self.training = 0
        self.tasks: dict[str, int] = {}  # text to number, in order of appearance
        self.moments: defaultdict[str, RunningStatistics] = defaultdict(RunningStatistics)  # by feature
        self._features = _features(plan)
        self._data = self.enter_context(_Table(folder / "data"))
        self._about = self.enter_context(_Table(folder / "meta" / "episodes"))
        self._rows: list[dict[str, Any]] = []  # of `_about`, waiting to be written
        self.callback(self._write_rows)

    def add(self, trajectory: ExportedTrajectory) -> None:
        frames = self._frames_of(trajectory)
        chunk, file = self._data.write(_data(frames, self._features))
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
            }
        )
        for name, values in frames.items():
            self.moments[name].add(values)
        self.episodes += 1
        self.frames += length
        self.training += trajectory.split == TRAIN
        if len(self._rows) == ROWS_AT_ONCE:
            self._write_rows()

    def stored(self) -> Iterator[dict[str, Any]]:
        """The frames again, some at a time, as arrays by feature; after the end."""
        for path in self._data.paths:
            with pq.ParquetFile(path) as file:
                for batch in file.iter_batches(FRAMES_AT_ONCE):
                    yield {name: _array(batch.column(name), batch.num_rows) for name in self._features}

    def _frames_of(self, trajectory: ExportedTrajectory) -> dict[str, Any]:
        """Every feature as one array over the frames of an episode."""
        steps = np.arange(len(trajectory.actions))
        task = self.tasks.setdefault(trajectory.task, len(self.tasks))
        return {
            "observation.state": trajectory.observations[:-1],
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


def _features(plan: ExportPlan) -> dict[str, Any]:
    """The features as info.json describes them."""
    size = LAYOUTS[plan.layout].size
    names = action_names(plan.view)
    scalar = {"shape": [1], "names": None}
    return {
        "observation.state": {
            "dtype": "float32",
            "shape": [size],
            "names": [f"{plan.layout}_{index}" for index in range(size)],
        },
        "action": {"dtype": "float32", "shape": [len(names)], "names": names},
        "next.reward": {"dtype": "float32", **scalar},
        "next.done": {"dtype": "bool", **scalar},
        "timestamp": {"dtype": "float32", **scalar},
        **{name: {"dtype": "int64", **scalar} for name in ("frame_index", "episode_index", "index", "task_index")},
    }


def _data(frames: dict[str, Any], features: dict[str, Any]) -> Any:
    columns, hints = {}, {}
    for name, feature in features.items():
        values, length, dtype = frames[name], feature["shape"][0], feature["dtype"]
        if values.ndim == 2:
            columns[name] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), length)
            hints[name] = {"feature": {"dtype": dtype, "_type": "Value"}, "length": length, "_type": "Sequence"}
        else:
            columns[name] = pa.array(values)
            hints[name] = {"dtype": dtype, "_type": "Value"}
    return pa.table(columns).replace_schema_metadata({"huggingface": json.dumps({"info": {"features": hints}})})


def _array(column: Any, length: int) -> Any:
    """A column as it was written: (T,) or (T, D)."""
    if pa.types.is_fixed_size_list(column.type):
        return column.flatten().to_numpy().reshape(length, -1)
    return column.to_numpy(zero_copy_only=False)


def _tasks(tasks: list[str]) -> Any:
    """A pandas frame whose index is the text, described by hand since pandas is not needed otherwise."""
    index = "__index_level_0__"
    text, number = pa.array(tasks), pa.array(range(len(tasks)), pa.int64())
    columns = [
        {
            "name": "task_index",
            "field_name": "task_index",
            "pandas_type": "int64",
            "numpy_type": "int64",
            "metadata": None,
        },
        {"name": None, "field_name": index, "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
    ]
    pandas = {"index_columns": [index], "column_indexes": [], "columns": columns, "pandas_version": "2.0.0"}
    return pa.table({"task_index": number, index: text}).replace_schema_metadata({"pandas": json.dumps(pandas)})


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
        "video_path": None,
        "features": _features(plan),
    }


def _write_json(path: Path, document: dict[str, Any]) -> None:
    path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
