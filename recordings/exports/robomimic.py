"""HDF5 in the layout of robomimic: data/demo_k with actions, rewards, dones, obs, next_obs; mask/train, mask/valid."""

import json
from typing import Any

import h5py
import numpy as np

from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TRAIN
from movingout.recordings.exports.target import new_target
from movingout.recordings.exports.trajectories import ExportedTrajectory, action_names, trajectories

SUFFIXES = ("", ".hdf5", ".h5")
OBSERVATION = "state"  # the one low-dimensional modality


def write(plan: ExportPlan) -> None:
    """One .hdf5 file; test episodes are robomimic's `valid`."""
    if plan.target.suffix not in SUFFIXES:
        raise RecordingError(f"{plan.target.name}: a robomimic file ends in .hdf5")
    names: dict[str, list[str]] = {"train": [], "valid": []}
    total = 0
    with new_target(plan.target) as path, h5py.File(path, "w") as file:
        data = file.create_group("data")
        for episode, part in plan.episodes("exporting"):
            for trajectory in trajectories(episode, part, plan.view, plan.layout):
                name = f"demo_{len(data)}"
                _write_demo(data.create_group(name), trajectory)
                names["train" if part == TRAIN else "valid"].append(name)
                total += len(trajectory.actions)
        if not total:
            raise RecordingError("no ticks in these recordings, so there is nothing to train on")
        data.attrs["total"] = total
        data.attrs["env_args"] = json.dumps(_environment(plan))
        for mask, demos in names.items():
            if demos:
                file.create_dataset(f"mask/{mask}", data=np.array(demos, dtype="S"))


def _write_demo(group: Any, trajectory: ExportedTrajectory) -> None:
    group.attrs["num_samples"] = len(trajectory.actions)
    group.attrs["recording"] = trajectory.episode_id
    group.attrs["seat"] = trajectory.seat
    group.attrs["task"] = trajectory.task
    arrays = {
        "actions": trajectory.actions,
        "rewards": trajectory.rewards,
        "dones": trajectory.dones.astype(np.int64),
        "states": trajectory.observations[:-1],
        f"obs/{OBSERVATION}": trajectory.observations[:-1],
        f"next_obs/{OBSERVATION}": trajectory.observations[1:],
    }
    for name, values in arrays.items():
        group.create_dataset(name, data=values, compression="gzip")


def _environment(plan: ExportPlan) -> dict[str, Any]:
    """What robomimic keeps about the environment: its name and the arguments that make it."""
    arguments = {"layout": plan.layout, "view": plan.view, "actions": action_names(plan.view)}
    return {"env_name": "moving_out", "type": 2, "env_kwargs": arguments}
