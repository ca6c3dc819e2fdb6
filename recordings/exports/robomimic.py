"""HDF5 in the layout of robomimic: data/demo_k with actions, rewards, dones, obs, next_obs; mask/train, mask/valid."""

import json
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from movingout.maps.library import is_generated_or_shipped
from movingout.maps.randomize import SPLITS
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.hdf5_file import hdf5_file
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TRAIN
from movingout.recordings.exports.target import new_target
from movingout.recordings.exports.trajectories import ExportedTrajectory, action_names, all_trajectories, headings
from movingout.world.observation import LAYOUTS

SUFFIXES = ("", ".hdf5", ".h5")
OBSERVATION = "flat"  # the one low-dimensional modality, by the name that robomimic gives it in Gym environments
ENVIRONMENT = "movingout.agents.environment:MovingOut-v1"  # also without `import movingout`
Task = tuple[str, str]  # a map and the split of its variants, "" for the map as designed
GYM = 2  # robomimic's number of this kind of environment


def write(plan: ExportPlan) -> None:
    """One .hdf5 file; test episodes are robomimic's `valid`. Raises RecordingError, also for a layout of pictures."""
    if plan.target.suffix not in SUFFIXES:
        raise RecordingError(f"{plan.target.name}: a robomimic file ends in .hdf5")
    layout = LAYOUTS.get(plan.layout)
    if layout is not None and layout.picture:
        raise RecordingError(
            f"robomimic's one observation is a row of numbers, and {plan.layout} is a picture, which the environment "
            "gives as one; take another --layout"
        )
    plan.check_seen()
    names: dict[str, list[str]] = {"train": [], "valid": []}
    total, played = 0, Counter[Task]()
    with new_target(plan.target) as path, hdf5_file(path) as file:
        data = file.create_group("data")
        make = partial(all_trajectories, view=plan.view, layout=plan.layout)
        for made in plan.converted(make, "exporting"):
            for trajectory in made:
                name = f"demo_{len(data)}"
                _write_demo(data.create_group(name), trajectory)
                names["train" if trajectory.split == TRAIN else "valid"].append(name)
                total += len(trajectory.actions)
                played[_task(trajectory)] += 1
        if not total:
            raise RecordingError("no ticks in these recordings, so there is nothing to train on")
        data.attrs["total"] = total
        data.attrs["env_args"] = json.dumps(_environment(plan, played))
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


def _task(trajectory: ExportedTrajectory) -> Task:
    """What was played: a variant is of the split that its name says, as `challenge2-train-7`."""
    drawn, _, rest = trajectory.variant.partition("-")
    part = rest.partition("-")[0]
    return trajectory.map, part if drawn == "challenge2" and part in SPLITS else trajectory.variant


def _environment(plan: ExportPlan, played: Counter[Task]) -> dict[str, Any]:
    """What robomimic keeps about the environment: its name for Gymnasium and the arguments that make it.

    With both actions in one, which no seat can play, there is no such environment.
    """
    about = {"layout": plan.layout, "view": plan.view, "actions": action_names(plan.view)}
    about["headings"] = headings(plan.view, plan.layout)
    if plan.view == "joint":
        return {"env_name": "moving_out", "type": GYM, "env_kwargs": {}, "movingout": about}
    name, split = _most_played(played, plan.tell)
    arguments = {"map": name, "partner": "scripted", "seat": "blue", "layout": plan.layout}
    if split in SPLITS:
        arguments["split"] = split
    return {"env_name": ENVIRONMENT, "type": GYM, "env_kwargs": arguments, "movingout": about}


def _most_played(played: Counter[Task], tell: Callable[[str], None]) -> Task:
    """What most demonstrations show. Tells of others among them, and of a map of one's own: its name finds no file."""
    ((task, number),) = played.most_common(1)
    name, split = task
    if not is_generated_or_shipped(name):
        tell(f"env_args name {name}, which is a map of your own: put the path of its file there before rollouts")
    drawn = split in SPLITS
    if others := played.total() - (number if drawn or not split else 0):
        what = f"variants of {name} ({split})" if drawn else f"{name} as designed"
        tell(f"env_args name {what}, but {others} of {played.total()} demos are of another map or other variants")
    return task
