"""How differently the scripted people play: the paper's four diversity measures for A, B, C and all together.

    python -m bench.diversity --maps HandOff,SingleRotation --people 10

Means over maps, beside the paper's figures for its own people. The paper gives neither units nor kernels, so only the
order of rows can be compared.
"""

import argparse
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from pathlib import Path

import numpy as np

from movingout.agents.data.dataset import Trajectory, read_trajectories, recording_files
from movingout.agents.data.demonstrations import episode_jobs, write_all
from movingout.agents.data.diversity import diversity
from movingout.agents.scripted.populations import PEOPLE, POPULATIONS, population
from movingout.maps import MapSpec, load_map
from movingout.maps.errors import MovingOutError
from movingout.maps.selection import selected_maps
from movingout.matches.paper.published import published_tables
from movingout.recordings.diversity.measures import Diversity
from movingout.world.constants import LIMIT_TICKS


def published() -> dict[str, Diversity]:
    """The paper's rows, "Dataset diversity across different data collection methods"."""
    rows = published_tables()["table:task_1_diversity"].rows
    return {f"paper: {row.name}": Diversity(*(figure.mean for figure in row.figures.values())) for row in rows}


def episodes_of(name: str, maps: list[MapSpec], people: int, ticks: int, workers: int) -> dict[str, list[Trajectory]]:
    """By map, one episode of each pair of neighbours in a population."""
    with tempfile.TemporaryDirectory() as folder:
        todo = episode_jobs(population(name)[:people], maps, 1, ticks, seed=0, prefix=name)
        list(write_all(todo, Path(folder), workers))
        trajectories = read_trajectories(recording_files([Path(folder)]))
    return {one.name: [trajectory for trajectory in trajectories if trajectory.map.name == one.name] for one in maps}


def mean_diversity(by_map: dict[str, list[Trajectory]]) -> Diversity:
    """The measures, averaged over maps."""
    return Diversity(*np.mean([astuple(diversity(trajectories)) for trajectories in by_map.values()], axis=0).tolist())


def measured(maps: list[MapSpec], people: int, ticks: int, workers: int) -> dict[str, Diversity]:
    """Diversity of each population and of all together."""
    found = {name: episodes_of(name, maps, people, ticks, workers) for name in POPULATIONS}
    everybody = {one.name: [trajectory for by_map in found.values() for trajectory in by_map[one.name]] for one in maps}
    return {**{name: mean_diversity(by_map) for name, by_map in found.items()}, "all": mean_diversity(everybody)}


def table(rows: Mapping[str, Diversity]) -> str:
    """A Markdown table with a row per set of episodes."""
    lines = ["| people | DTW mean | DTW variance | entropy | coverage |", "|---|---|---|---|---|"]
    for name, numbers in rows.items():
        lines.append(f"| {name} | " + " | ".join(f"{value:.3f}" for value in astuple(numbers)) + " |")
    return "\n".join(lines)


def main(words: Sequence[str] | None = None) -> None:
    """Parse, play and print; exit with a message if that is impossible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", default="all")
    parser.add_argument("--people", type=int, default=10, help=f"per population; an even number from 4 to {PEOPLE}")
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args(words)
    if args.people not in range(4, PEOPLE + 1, 2):
        parser.error(f"--people must be an even number from 4 to {PEOPLE}: one pair alone cannot be compared")
    if min(args.ticks, args.workers) < 1:
        parser.error("--ticks and --workers must be at least 1")
    try:
        maps = [load_map(name) for name in selected_maps(args.maps)]
        rows = measured(maps, args.people, args.ticks, args.workers)
    except MovingOutError as error:
        parser.error(str(error))
    print(table({**rows, **published()}))
    pairs = args.people // 2
    print(f"\nMaps: {len(maps)}. Per population {pairs} pairs, one episode of up to {args.ticks} ticks on each map.")


if __name__ == "__main__":
    main()
