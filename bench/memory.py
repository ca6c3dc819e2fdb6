"""Memory kept after matches end: one process plays many short matches on all maps and their variants, between agents
that drive to items, grab them and let go."""

import ctypes
import gc
import time
from collections.abc import Iterator
from itertools import count, islice
from pathlib import Path

import numpy as np

from bench import print_table
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.maps import map_names
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match

MATCHES = 100_000
PAGE = 4096  # bytes
TICKS = 8  # short matches: leaks would come from starting and ending
GRABBER = "bench.memory:Grabber"


class Grabber:
    """Drives to an item and toggles its grasp every third tick."""

    def reset(self, episode: EpisodeInfo) -> None:
        self.item = episode.seed % len(episode.map.items)

    def act(self, observation: Observation) -> ActionChunk:
        """Return three actions (3, 4) towards the item."""
        state, seat = observation.state, observation.seat
        x, y = (state.item_poses[self.item, :2] - state.robot_poses[seat, :2]).tolist()
        length = max((x * x + y * y) ** 0.5, 1e-3)
        row = [1.0, y / length, -x / length]
        return np.array([[*row, 1.0], [*row, 0.0], [*row, 0.0]])


def main() -> None:
    begun = time.process_time()
    readings = [[f"{number:,}", f"{megabytes:.1f}"] for number, megabytes in sizes(MATCHES, MATCHES // 10)]
    print_table("Memory of one process by matches played", ["matches", "MB"], readings)
    print(f"{MATCHES:,} matches of up to {TICKS} ticks in {time.process_time() - begun:.0f} s of CPU time")


def sizes(matches: int, every: int) -> Iterator[tuple[int, float]]:
    """(matches played, resident size in MB) after each `every` matches."""
    results = Lockstep().play(islice(short_matches(), matches))
    for number, result in enumerate(results, start=1):
        assert result.ending != "failed", result.failure
        if number % every == 0:
            yield number, resident_mb()


def short_matches() -> Iterator[Match]:
    """Endless matches on all maps, with new seeds; every tenth seed plays the variants."""
    for seed in count():
        for name in map_names():
            yield Match(name, GRABBER, GRABBER, seed, 1 if seed % 10 else 2, TICKS)


def resident_mb() -> float:
    """Resident size of this process [MB], after free memory was returned to the system."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 2**20
