"""HDF5 in the layout of robomimic: data/demo_k with actions, rewards, dones, obs, next_obs; mask/train, mask/valid."""

import json
import warnings
from collections import Counter
from functools import partial
from typing import Any

import numpy as np

from movingout.maps.library import is_generated_or_shipped
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.hdf5_file import hdf5_file
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TRAIN
from movingout.recordings.exports.target import new_target
from movingout.recordings.exports.trajectories import ExportedTrajectory, action_names, all_trajectories

SUFFIXES = ("", ".hdf5", ".h5")
OBSERVATION = "flat"  # the one low-dimensional modality, by the name that robomimic gives it in Gym environments
ENVIRONMENT = "movingout.agents.environment:MovingOut-v1"  # also without `import movingout`
GYM = 2  # robomimic's number of this kind of environment


def write(plan: ExportPlan) -> None:
    """One .hdf5 file; test episodes are robomimic's `valid`."""
    if plan.target.suffix not in SUFFIXES:
        raise RecordingError(f"{plan.target.name}: a robomimic file ends in .hdf5")
    names: dict[str, list[str]] = {"train": [], "valid": []}
    total = 0
    with new_target(plan.target) as path, hdf5_file(path) as file:
        data = file.create_group("data")
        make = partial(all_trajectories, view=plan.view, layout=plan.layout)
        for made in plan.converted(make, "exporting"):
            for trajectory in made:
                name = f"demo_{len(data)}"
                _write_demo(data.create_group(name), trajectory)
                names["train" if trajectory.split == TRAIN else "valid"].append(name)
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
    """What robomimic keeps about the environment: its name for Gymnasium and the arguments that make it.

    With both actions in one, which no seat can play, there is no such environment.
    """
    about = {"layout": plan.layout, "view": plan.view, "actions": action_names(plan.view)}
    if plan.view == "joint":
        return {"env_name": "moving_out", "type": GYM, "env_kwargs": {}, "movingout": about}
    arguments = {"map": _most_played(plan), "partner": "scripted", "seat": "blue", "layout": plan.layout}
    return {"env_name": ENVIRONMENT, "type": GYM, "env_kwargs": arguments, "movingout": about}


def _most_played(plan: ExportPlan) -> str:
    """The map of most recordings that comes with the project; else that of most, with a warning.

    A map of one's own is not found by its name.
    """
    played = Counter(players.map for players in plan.players)
    known = [name for name, _ in played.most_common() if is_generated_or_shipped(name)]
    if known:
        return known[0]
    own: str = played.most_common(1)[0][0]
    sentence = f"env_args name {own}, which is a map of your own: put the path of its file there before rollouts"
    warnings.warn(sentence, RuntimeWarning, stacklevel=2)
    return own
