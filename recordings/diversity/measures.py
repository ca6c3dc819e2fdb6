"""The paper's four measures of diversity ("Evaluate the diversity of Challenge 1"), with standard errors.

A path (T, 4) is where both robots were after each tick: x, y of blue and red. Sets of paths are compared on the same
map. The paper names the measures but neither the units and lengths of paths nor the widths of kernels: they are options
here, and only figures made with the same options can be compared.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from itertools import combinations

import numpy as np

from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats, Ints

_CELLS = 5_000_000  # of the tables of pairs of paths that are aligned at once: 160 MB


@dataclass(frozen=True, slots=True)
class DiversityOptions:
    """How paths become figures."""

    points: int = 50  # from 1: each path is resampled to so many points, evenly in time
    grid: int = 24  # from 2: cells per side for the entropy
    bandwidth: float = 0.1  # [arena units] of the kernel density
    rbf_width: float = 1.0  # [arena units] of the coverage kernel, on mean distances between paths


DEFAULT = DiversityOptions()


@dataclass(frozen=True, slots=True)
class Diversity:
    """Of one set of episodes on one map; higher is more diverse."""

    dtw_mean: float
    dtw_variance: float
    entropy: float  # of where the robots are, in [0, 1]: 1 is everywhere equally
    coverage: float  # mean of 1 - exp(-d^2 / 2 w^2) over pairs of paths, in [0, 1]


class PathSet:
    """Paths on one map with everything that is computed once: distances of all pairs, and densities of all places."""

    def __init__(self, paths: Sequence[Floats], options: DiversityOptions = DEFAULT) -> None:
        self._options = options
        self.alike = _alike(paths)
        short = np.stack([resampled(path, options.points) for path in paths])
        self._costs, self._gaps = _pair_distances(short, options.points)
        self._densities = np.stack([_density(path.reshape(-1, 2), options) for path in paths])

    def diversity(self, chosen: Sequence[int] | Ints | None = None) -> Diversity:
        """The measures of these paths (default: all). Three of them need two paths and are 0 with fewer."""
        index = np.arange(len(self.alike)) if chosen is None else np.asarray(chosen)
        first, second = np.triu_indices(len(index), 1)
        costs, gaps = (table[index[first], index[second]] for table in (self._costs, self._gaps))
        width = self._options.rbf_width
        return Diversity(
            dtw_mean=float(costs.mean()) if len(costs) else 0.0,
            dtw_variance=float(costs.var()) if len(costs) else 0.0,
            entropy=_entropy(self._densities[index].sum(axis=0)),
            coverage=float((1 - np.exp(-(gaps**2) / (2 * width**2))).mean()) if len(gaps) else 0.0,
        )

    def distinct(self, chosen: Sequence[int] | Ints | None = None) -> int:
        """How many of these paths differ from one another."""
        return len(set(self.alike if chosen is None else [self.alike[one] for one in chosen]))

    def standard_errors(self, chosen: Sequence[int] | Ints | None = None) -> Diversity | None:
        """By the jackknife: every distinct path is left out once, with all its copies. None with fewer than three.

        Pairs that share a path depend on each other, so s / sqrt(pairs) would be too small. With fewer than four, that
        of the variance is NaN: two paths have one distance, which has no variance.
        """
        index = np.arange(len(self.alike)) if chosen is None else np.asarray(chosen)
        labels = np.array([self.alike[one] for one in index])
        groups = sorted(set(labels.tolist()))
        if len(groups) < 3:
            return None
        without = np.array([astuple(self.diversity(index[labels != label])) for label in groups])
        spread = ((without - without.mean(axis=0)) ** 2).sum(axis=0)
        errors = Diversity(*np.sqrt(spread * (len(groups) - 1) / len(groups)).tolist())
        return errors if len(groups) > 3 else replace(errors, dtw_variance=math.nan)


def resampled(path: Floats, points: int) -> Floats:
    """(points, 4) of a path (T, 4), evenly in time."""
    chosen: Floats = path[np.linspace(0, len(path) - 1, points).round().astype(int)]
    return chosen


def dynamic_time_warping(one: Floats, other: Floats) -> Floats:
    """(P,) the cheapest alignments of pairs of paths (P, M, 4) and (P, N, 4): sums of distances of aligned points."""
    gaps = np.linalg.norm(one[:, :, None] - other[:, None], axis=-1)
    costs = np.full((len(one), one.shape[1] + 1, other.shape[1] + 1), np.inf)
    costs[:, 0, 0] = 0.0
    for row in range(1, costs.shape[1]):
        for column in range(1, costs.shape[2]):
            straight = np.minimum(costs[:, row - 1, column], costs[:, row, column - 1])
            costs[:, row, column] = gaps[:, row - 1, column - 1] + np.minimum(straight, costs[:, row - 1, column - 1])
    ends: Floats = costs[:, -1, -1]
    return ends


def _alike(paths: Sequence[Floats]) -> list[int]:
    """For each path the number of the first one that is equal to it to the bit."""
    first: dict[bytes, int] = {}
    return [first.setdefault(np.ascontiguousarray(path).tobytes(), number) for number, path in enumerate(paths)]


def _pair_distances(paths: Floats, points: int) -> tuple[Floats, Floats]:
    """(N, N) costs of alignment and mean distances at equal times, of all pairs of paths (N, points, 4)."""
    costs, gaps = np.zeros((2, len(paths), len(paths)))
    pairs = np.array(list(combinations(range(len(paths)), 2)), dtype=int).reshape(-1, 2)
    batch = max(_CELLS // points**2, 1)
    for start in range(0, len(pairs), batch):
        one, other = pairs[start : start + batch].T
        costs[one, other] = costs[other, one] = dynamic_time_warping(paths[one], paths[other])
        gaps[one, other] = gaps[other, one] = np.linalg.norm(paths[one] - paths[other], axis=-1).mean(axis=-1)
    return costs, gaps


def _density(places: Floats, options: DiversityOptions) -> Floats:
    """(grid, grid) how much of the time was spent around each cell; densities of several paths can be added."""
    edges = np.linspace(-ARENA_HALF, ARENA_HALF, options.grid + 1)
    density, _, _ = np.histogram2d(places[:, 0], places[:, 1], bins=(edges, edges))
    offsets = np.subtract.outer(edges[:-1], edges[:-1])
    kernel = np.exp(-(offsets**2) / (2 * options.bandwidth**2))
    smooth: Floats = kernel @ density @ kernel
    return smooth


def _entropy(density: Floats) -> float:
    shares = density[density > 0] / density.sum()
    return float(-(shares * np.log(shares)).sum() / np.log(density.size))
