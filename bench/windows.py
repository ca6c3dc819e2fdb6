"""How fast episodes become windows, and windows become tensors in batches, as training draws them.

    python -m bench.windows --data data/demos

CPU time of one thread. Without --data, episodes are random driving on all maps. Rows are repeated up to the size of a
usual training set, so that they do not fit into a cache. Episodes are encoded once, before training; tables computed
once per map (0.2 s) are not counted.
"""

import argparse
import time
from collections.abc import Sequence
from itertools import cycle, islice
from pathlib import Path

import numpy as np
import torch

from bench import print_table
from bench.world import driving
from movingout.agents.data.corrections import SUFFIX, load_correction
from movingout.agents.data.dataset import (
    Trajectory,
    Windows,
    read_trajectories,
    recording_files,
    trajectory_samples,
    windows_of,
)
from movingout.agents.kinds.registry import KINDS
from movingout.agents.observation.seat_observation import start_state
from movingout.agents.policies.config import PolicyConfig
from movingout.maps import load_map, map_names
from movingout.maps.errors import MovingOutError
from movingout.world import World
from movingout.world.observation import encoder

TARGET = 500_000  # windows/s
ROWS = 200_000
BATCHES = 400
PRESETS = (("dp", "fast"), ("gru", "fast"), ("dp", "paper"))


def driven(map_name: str, seed: int) -> Trajectory:
    """An episode of random driving."""
    world, actions = World(load_map(map_name), record_sub_poses=False), np.array(driving(seed))
    states = [world.state()]
    for action in actions:
        world.step(action)
        states.append(world.state())
    return Trajectory(
        load_map(map_name),
        (f"blue {seed}", f"red {seed}"),
        np.array([state.robot_poses for state in states]),
        np.array([state.robot_velocities for state in states]),
        np.array([state.held for state in states]),
        np.array([state.item_poses for state in states]),
        actions,
    )


def encoded(trajectories: Sequence[Trajectory], config: PolicyConfig) -> tuple[Windows, float]:
    """Return at least ROWS windows, or all if there are more, and the encoding rate [1/s]."""
    for the_map in {trajectory.map for trajectory in trajectories}:
        encoder(the_map, config.layout).encode(start_state(the_map), seat=0)
    begun = time.process_time()
    pieces = list(trajectory_samples(trajectories, config.layout, config.spec("dp").grasp))
    rate = sum(len(piece.features) for piece in pieces) / (time.process_time() - begun)
    mean = sum(len(piece.features) for piece in pieces) / len(pieces)
    return windows_of(islice(cycle(pieces), max(round(ROWS / mean), len(pieces)))), rate


def drawn(windows: Windows, config: PolicyConfig, batches: int) -> float:
    """Rate [1/s] at which random windows become tensors (observations and chunks), in batches."""
    random, rows = np.random.default_rng(0), np.arange(len(windows))
    begun = time.process_time()
    for _ in range(batches):
        chosen = random.choice(rows, config.batch)
        torch.from_numpy(windows.observations(chosen, config.obs_horizon))
        torch.from_numpy(windows.chunks(chosen, config.horizon))
    return batches * config.batch / (time.process_time() - begun)


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, nargs="+", help="recordings; default: random driving on all maps")
    args = parser.parse_args(words)
    try:
        trajectories = (
            recorded(args.data) if args.data else [driven(name, seed) for seed, name in enumerate(map_names())]
        )
        table = [_row(trajectories, kind, preset) for kind, preset in PRESETS]
    except MovingOutError as error:
        parser.error(str(error))
    columns = ["preset", "layout", "numbers", "seen x ahead", "encoded/s", "drawn/s", "to reach"]
    print_table(f"Windows of {len(trajectories)} episodes as tensors, CPU time of one thread", columns, table)


def recorded(places: Sequence[Path]) -> list[Trajectory]:
    """Read recordings and label files."""
    files = recording_files(places, (".mcap", SUFFIX))
    labelled = [load_correction(file).trajectory for file in files if file.name.endswith(SUFFIX)]
    return labelled + read_trajectories([file for file in files if not file.name.endswith(SUFFIX)])


def _row(trajectories: Sequence[Trajectory], kind: str, preset: str) -> list[str]:
    config = KINDS[kind].presets[preset]
    windows, encoding = encoded(trajectories, config)
    horizons = f"{config.obs_horizon} x {config.horizon}"
    rate = drawn(windows, config, BATCHES)
    return [
        *(f"{kind} {preset}", config.layout, str(windows.features.shape[1]), horizons),
        *(f"{encoding:,.0f}", f"{rate:,.0f}", f"{TARGET:,}"),
    ]


if __name__ == "__main__":
    main()
