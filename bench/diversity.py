"""How different the scripted people play: the paper's four measures of diversity for A, B, C and all together.

    python -m bench.diversity --maps HandOff,SingleRotation --people 10

Mean over maps. The paper has the same measures of its own people and maps; only the order can be compared.
"""

import argparse
import os
import tempfile
from dataclasses import astuple
from pathlib import Path

import numpy as np

from agents.dataset import Trajectory, read_trajectories, recording_files
from agents.demonstrations import jobs, make_all
from agents.diversity import Diversity, diversity
from agents.populations import POPULATIONS, population
from maps import load_map, map_names


def episodes_of(name: str, maps: list[str], people: int, ticks: int, workers: int) -> dict[str, list[Trajectory]]:
    """One episode of each pair of neighbours in a population, by map."""
    with tempfile.TemporaryDirectory() as folder:
        todo = jobs(population(name)[:people], [load_map(one) for one in maps], 1, ticks, seed=0, prefix=name)
        list(make_all(todo, Path(folder), workers))
        walks = read_trajectories(recording_files([Path(folder)]))
    return {one: [walk for walk in walks if walk.map.name == one] for one in maps}


def mean_diversity(by_map: dict[str, list[Trajectory]]) -> Diversity:
    """The measures of each map, averaged."""
    return Diversity(*np.mean([astuple(diversity(walks)) for walks in by_map.values()], axis=0).tolist())


def table(rows: dict[str, Diversity]) -> str:
    """One row per set of episodes."""
    lines = ["| people | DTW mean | DTW variance | entropy | coverage |", "|---|---|---|---|---|"]
    for name, numbers in rows.items():
        lines.append(f"| {name} | " + " | ".join(f"{value:.3f}" for value in astuple(numbers)) + " |")
    return "\n".join(lines)


def main() -> None:
    """Parse, play, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", default="all")
    parser.add_argument("--people", type=int, default=10, help="of each population, an even number")
    parser.add_argument("--ticks", type=int, default=500)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args()
    maps = list(map_names()) if args.maps == "all" else args.maps.split(",")
    found = {name: episodes_of(name, maps, args.people, args.ticks, args.workers) for name in POPULATIONS}
    everybody = {one: [walk for by_map in found.values() for walk in by_map[one]] for one in maps}
    rows = {name: mean_diversity(by_map) for name, by_map in found.items()}
    print(table({**rows, "all": mean_diversity(everybody)}))


if __name__ == "__main__":
    main()
