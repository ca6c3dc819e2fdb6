"""The features of our LeRobot data sets: what a frame consists of, in info.json and as columns of Parquet."""

import json
from typing import Any

import pyarrow as pa

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.trajectories import ExportedTrajectory, action_names
from movingout.world.observation import LAYOUTS

STATE, ENVIRONMENT, VIEW = "observation.state", "observation.environment_state", "observation.images.view"


def features(plan: ExportPlan) -> dict[str, Any]:
    """The features of a frame by name.

    A layout is divided as LeRobot's policies want it: `observation.state` is the robot (with both actions: both
    robots), `observation.environment_state` everything else. One after the other they are the layout.
    """
    own, size = _robots(plan.view, plan.layout), LAYOUTS[plan.layout].size
    names = action_names(plan.view)
    scalar = {"shape": [1], "names": None}
    return {
        STATE: _vector(plan.layout, 0, own),
        ENVIRONMENT: _vector(plan.layout, own, size),
        "action": {"dtype": "float32", "shape": [len(names)], "names": names},
        "next.reward": {"dtype": "float32", **scalar},
        "next.done": {"dtype": "bool", **scalar},
        "timestamp": {"dtype": "float32", **scalar},
        **{name: {"dtype": "int64", **scalar} for name in ("frame_index", "episode_index", "index", "task_index")},
    }


def divided(trajectory: ExportedTrajectory, view: str, layout: str) -> dict[str, Any]:
    """The two parts of the observations (T, ·) of a trajectory."""
    own, seen = _robots(view, layout), trajectory.observations[:-1]
    return {STATE: seen[:, :own], ENVIRONMENT: seen[:, own:]}


def table_of(frames: dict[str, Any], described: dict[str, Any]) -> Any:
    """The frames of an episode as a table, with what Hugging Face's `datasets` wants to know about its columns."""
    columns, hints = {}, {}
    for name, feature in described.items():
        values, length, dtype = frames[name], feature["shape"][0], feature["dtype"]
        if values.ndim == 2:
            columns[name] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), length)
            hints[name] = {"feature": {"dtype": dtype, "_type": "Value"}, "length": length, "_type": "Sequence"}
        else:
            columns[name] = pa.array(values)
            hints[name] = {"dtype": dtype, "_type": "Value"}
    return pa.table(columns).replace_schema_metadata({"huggingface": json.dumps({"info": {"features": hints}})})


def column_array(column: Any, length: int) -> Any:
    """A column as it was written: (T,) or (T, D)."""
    if pa.types.is_fixed_size_list(column.type):
        return column.flatten().to_numpy().reshape(length, -1)
    return column.to_numpy(zero_copy_only=False)


def tasks_table(tasks: list[str]) -> Any:
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


def _robots(view: str, layout: str) -> int:
    """How many numbers of a layout describe the robots that act."""
    own = LAYOUTS[layout].own_numbers
    return 2 * own if view == "joint" else own


def _vector(layout: str, start: int, end: int) -> dict[str, Any]:
    names = [f"{layout}_{index}" for index in range(start, end)]
    return {"dtype": "float32", "shape": [end - start], "names": names}
