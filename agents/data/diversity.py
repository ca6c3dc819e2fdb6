"""How diverse a set of episodes is: the paper's four measures ("Evaluate the diversity of Challenge 1").

Trajectories are the paths (T, 4) of both robots' places; sets are compared on the same map.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from movingout.agents.data.dataset import Trajectory
from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats

POINTS = 50  # each path is resampled to so many points, evenly in time
GRID = 24  # cells per side for the entropy
BANDWIDTH = 0.1  # [u] of the kernel density
RBF_WIDTH = 1.0  # [u] of the coverage kernel, on mean distances between paths


@dataclass(frozen=True, slots=True)
class Diversity:
    """Of one set of episodes on one map; higher is more diverse."""

    dtw_mean: float
    dtw_variance: float
    entropy: float  # of where the robots are, in [0, 1]: 1 is everywhere equally
    coverage: float  # mean of 1 - exp(-d^2 / 2 w^2) over pairs of paths, in [0, 1]


def diversity(trajectories: Sequence[Trajectory]) -> Diversity:
    """The four measures. Three of them need two episodes and are 0 with fewer."""
    paths = [path_of(trajectory) for trajectory in trajectories]
    places = np.concatenate([trajectory.robot_poses[..., :2].reshape(-1, 2) for trajectory in trajectories])
    pairs = list(combinations(paths, 2))
    costs = np.array([dynamic_time_warping(a, b) for a, b in pairs]) if pairs else np.zeros(1)
    gaps = np.array([np.linalg.norm(a - b, axis=1).mean() for a, b in pairs]) if pairs else np.zeros(1)
    return Diversity(
        dtw_mean=float(costs.mean()),
        dtw_variance=float(costs.var()),
        entropy=place_entropy(places),
        coverage=float((1 - np.exp(-(gaps**2) / (2 * RBF_WIDTH**2))).mean()),
    )


def path_of(trajectory: Trajectory) -> Floats:
    """(POINTS, 4): x, y of blue and red."""
    places = trajectory.robot_poses[..., :2].reshape(len(trajectory.robot_poses), 4)
    path: Floats = places[np.linspace(0, len(places) - 1, POINTS).round().astype(int)]
    return path


def dynamic_time_warping(one: Floats, other: Floats) -> float:
    """The cheapest alignment of two paths (P, 4) and (Q, 4): the sum of the distances of aligned points."""
    gaps = np.linalg.norm(one[:, None] - other[None], axis=-1)
    costs = np.full((len(one) + 1, len(other) + 1), np.inf)
    costs[0, 0] = 0.0
    for row in range(1, len(one) + 1):
        for column in range(1, len(other) + 1):
            before = min(costs[row - 1, column], costs[row, column - 1], costs[row - 1, column - 1])
            costs[row, column] = gaps[row - 1, column - 1] + before
    return float(costs[-1, -1])


def place_entropy(places: Floats) -> float:
    """Entropy of a kernel density of places (M, 2) on a grid, divided by that of the uniform density."""
    edges = np.linspace(-ARENA_HALF, ARENA_HALF, GRID + 1)
    counts, _, _ = np.histogram2d(places[:, 0], places[:, 1], bins=(edges, edges))
    offsets = np.arange(-3, 4) * (edges[1] - edges[0])
    kernel = np.exp(-(offsets**2) / (2 * BANDWIDTH**2))
    for axis in (0, 1):
        counts = np.apply_along_axis(lambda line: np.convolve(line, kernel, mode="same"), axis, counts)
    shares = counts[counts > 0] / counts.sum()
    return float(-(shares * np.log(shares)).sum() / np.log(GRID * GRID))
