"""Episodes that no agent has learned from: people of population C, who are never trained with."""

import tempfile
from pathlib import Path

from movingout.agents.data.dataset import Trajectory, read_trajectories, recording_files
from movingout.agents.data.demonstrations import episode_jobs, write_all
from movingout.agents.scripted.populations import population
from movingout.maps import load_map, map_names
from movingout.maps.randomize import randomize


def held_out_episodes(challenge: int, ticks: int, workers: int) -> list[Trajectory]:
    """One episode per map by ten pairs of C in turn; in Challenge 2, on variants that nobody is trained on."""
    maps = [load_map(name) for name in map_names()]
    if challenge == 2:
        maps = [randomize(the_map, 0, "evaluation") for the_map in maps]
    people = population("C")
    todo = []
    for number, the_map in enumerate(maps):
        pair = [people[(2 * number + k) % len(people)] for k in (0, 1)]
        if number // 2 % 2:  # the first of a pair follows; swapping puts leaders in both seats
            pair.reverse()
        todo += episode_jobs(pair, [the_map], 1, ticks, seed=0, prefix="parts")
    with tempfile.TemporaryDirectory() as folder:
        list(write_all(todo, Path(folder), workers))
        return read_trajectories(recording_files([Path(folder)]))
