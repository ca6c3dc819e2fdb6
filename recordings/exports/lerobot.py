"""LeRobotDataset v3.0, written with pyarrow alone (lerobot itself would bring 8 GB).

The layout is that of lerobot 0.4 (`codebase_version` v3.0): meta/info.json, meta/stats.json, meta/tasks.parquet (a
pandas frame indexed by the task's text), meta/episodes and data as parquet in chunk-000/file-000. docs/exports.md says
how loading in the real library was checked.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from recordings.errors import RecordingError
from recordings.exports.plan import Plan
from recordings.exports.split import TEST, TRAIN
from recordings.exports.target import building
from recordings.exports.trajectories import Singles, Trajectory, action_names, trajectories
from world.observation import LAYOUTS

FPS = 10
_PLACE = "chunk-000/file-000.parquet"
_QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)


def write(plan: Plan) -> None:
    """A dataset folder. Training episodes come first, since a LeRobot split is a range of episodes."""
    found = [
        t for episode, part in plan.episodes("exporting") for t in trajectories(episode, part, plan.view, plan.layout)
    ]
    if not found:
        raise RecordingError("no ticks in these recordings, so there is nothing to train on")
    found.sort(key=lambda trajectory: trajectory.split != TRAIN)
    tasks = sorted({trajectory.task for trajectory in found})
    frames = _frames(found, tasks)
    with building(plan.target) as folder:
        _write_table(folder / "data" / _PLACE, _data(found, frames, plan))
        _write_table(folder / "meta" / "episodes" / _PLACE, _episodes(found, frames))
        _write_table(folder / "meta" / "tasks.parquet", _tasks(tasks))
        _write_json(folder / "meta" / "info.json", _info(found, tasks, plan))
        _write_json(folder / "meta" / "stats.json", _stats(frames))


def _frames(found: Sequence[Trajectory], tasks: list[str]) -> dict[str, Any]:
    """Every feature as one array over all frames."""
    lengths = [len(trajectory.actions) for trajectory in found]
    steps = np.concatenate([np.arange(length) for length in lengths])
    numbers = np.repeat(np.arange(len(found)), lengths)
    return {
        "observation.state": np.concatenate([trajectory.observations[:-1] for trajectory in found]),
        "action": np.concatenate([trajectory.actions for trajectory in found]),
        "next.reward": np.concatenate([trajectory.rewards for trajectory in found]),
        "next.done": np.concatenate([trajectory.dones for trajectory in found]),
        "timestamp": (steps / FPS).astype(np.float32),
        "frame_index": steps,
        "episode_index": numbers,
        "index": np.arange(len(steps)),
        "task_index": np.repeat([tasks.index(trajectory.task) for trajectory in found], lengths),
    }


def _features(plan: Plan) -> dict[str, Any]:
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


def _data(found: Sequence[Trajectory], frames: dict[str, Any], plan: Plan) -> Any:
    columns, hints = {}, {}
    for name, feature in _features(plan).items():
        values, length = frames[name], feature["shape"][0]
        dtype = feature["dtype"]
        if values.ndim == 2:
            columns[name] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), length)
            hints[name] = {"feature": {"dtype": dtype, "_type": "Value"}, "length": length, "_type": "Sequence"}
        else:
            columns[name] = pa.array(values)
            hints[name] = {"dtype": dtype, "_type": "Value"}
    return pa.table(columns).replace_schema_metadata({"huggingface": json.dumps({"info": {"features": hints}})})


def _episodes(found: Sequence[Trajectory], frames: dict[str, Any]) -> Any:
    ends = np.cumsum([len(trajectory.actions) for trajectory in found]).tolist()
    rows = []
    for number, (trajectory, start, end) in enumerate(zip(found, [0, *ends], ends, strict=False)):
        row: dict[str, Any] = {
            "episode_index": number,
            "tasks": [trajectory.task],
            "length": end - start,
            "data/chunk_index": 0,
            "data/file_index": 0,
            "dataset_from_index": start,
            "dataset_to_index": end,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
            "recording": trajectory.episode_id,
            "seat": trajectory.seat,
        }
        for name, values in frames.items():
            row |= {f"stats/{name}/{key}": value for key, value in _statistics(values[start:end]).items()}
        rows.append(row)
    return pa.Table.from_pylist(rows)


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


def _info(found: Sequence[Trajectory], tasks: list[str], plan: Plan) -> dict[str, Any]:
    training = sum(trajectory.split == TRAIN for trajectory in found)
    splits = {TRAIN: f"0:{training}", TEST: f"{training}:{len(found)}"}
    return {
        "codebase_version": "v3.0",
        "robot_type": "moving_out",
        "total_episodes": len(found),
        "total_frames": sum(len(trajectory.actions) for trajectory in found),
        "total_tasks": len(tasks),
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": FPS,
        "splits": splits if training < len(found) else {TRAIN: splits[TRAIN]},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
        "features": _features(plan),
    }


def _stats(frames: dict[str, Any]) -> dict[str, Any]:
    return {name: _statistics(values) for name, values in frames.items()}


def _statistics(values: Singles) -> dict[str, list[float] | list[int]]:
    """Per number of a feature: min, max, mean, standard deviation, quantiles; and how many frames."""
    rows = values.reshape(len(values), -1).astype(np.float64)
    quantiles = {f"q{round(q * 100):02d}": np.quantile(rows, q, axis=0).tolist() for q in _QUANTILES}
    return {
        "min": rows.min(axis=0).tolist(),
        "max": rows.max(axis=0).tolist(),
        "mean": rows.mean(axis=0).tolist(),
        "std": rows.std(axis=0).tolist(),
        "count": [len(rows)],
        **quantiles,
    }


def _write_table(path: Path, table: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(table, path, compression="zstd")


def _write_json(path: Path, document: dict[str, Any]) -> None:
    path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
