"""The four measures of how different paths are, and their standard errors."""

from dataclasses import astuple

import numpy as np
import pytest

from movingout.maps.spec import ARENA_HALF
from movingout.recordings.diversity.comparison import named
from movingout.recordings.diversity.measures import DiversityOptions, PathSet, dynamic_time_warping
from movingout.world.state import Floats


def walk(seed: int, ticks: int = 60) -> Floats:
    steps = np.random.default_rng(seed).normal(scale=0.05, size=(ticks, 4))
    return np.clip(np.cumsum(steps, axis=0), -1.1, 1.1)


def test_time_warping_forgives_a_pause_but_not_another_way() -> None:
    way = np.column_stack([np.linspace(0, 1, 20)] * 4)
    paused = np.concatenate((way[:10], np.tile(way[9], (15, 1)), way[10:]))
    assert dynamic_time_warping(way[None], paused[None]).tolist() == [0.0]
    assert dynamic_time_warping(way[None], (way[:, ::-1] * (1, -1, 1, -1))[None])[0] > 1.0


def test_pairs_are_aligned_as_each_alone() -> None:
    ones, others = np.stack([walk(1), walk(2)]), np.stack([walk(3), walk(4)])
    alone = [dynamic_time_warping(ones[k : k + 1], others[k : k + 1])[0] for k in (0, 1)]
    assert dynamic_time_warping(ones, others).tolist() == alone


def test_entropy_is_one_when_all_places_are_visited_equally_and_small_for_one_place() -> None:
    everywhere = np.stack(np.meshgrid(*[np.linspace(-1.19, 1.19, 96)] * 2), axis=-1).reshape(-1, 2)
    assert PathSet([np.tile(everywhere, 2)]).diversity().entropy > 0.99
    assert PathSet([np.zeros((10, 4))]).diversity().entropy < 0.5


@pytest.mark.parametrize(("grid", "bandwidth"), [(24, 0.1), (24, 0.5), (100, 0.1), (4, 0.3)])
def test_the_density_is_that_of_the_whole_kernel_on_the_grid_that_was_asked_for(grid: int, bandwidth: float) -> None:
    """The kernel ended three cells away, however wide, and a grid of fewer than seven cells became one of seven."""
    places, middles = walk(0)[:, :2], (np.arange(grid) + 0.5) * 2 * ARENA_HALF / grid - ARENA_HALF
    cells = np.floor((places + ARENA_HALF) / (2 * ARENA_HALF / grid)).astype(int)
    density = np.zeros((grid, grid))
    for x, y in middles[cells]:
        square = (middles[:, None] - x) ** 2 + (middles[None] - y) ** 2
        density += np.exp(-square / (2 * bandwidth**2))
    shares = density[density > 0] / density.sum()
    expected = -(shares * np.log(shares)).sum() / np.log(grid**2)
    options = DiversityOptions(grid=grid, bandwidth=bandwidth)
    assert PathSet([np.tile(places, 2)], options).diversity().entropy == pytest.approx(expected)


def test_a_part_is_measured_as_if_the_rest_were_not_there() -> None:
    paths = [walk(seed) for seed in range(5)]
    part = PathSet(paths).diversity([1, 3, 4])
    assert astuple(part) == pytest.approx(astuple(PathSet([paths[k] for k in (1, 3, 4)]).diversity()))


def test_copies_are_counted_once_and_are_left_out_together() -> None:
    paths = [walk(seed) for seed in range(4)]
    twice = PathSet([*paths, *paths])
    assert (PathSet(paths).distinct(), twice.distinct(), twice.distinct([0, 4])) == (4, 4, 1)
    once, both = PathSet(paths).standard_errors(), twice.standard_errors()
    assert once is not None and both is not None
    assert both.entropy == pytest.approx(once.entropy)  # copies add nothing to what is known about places
    assert PathSet([paths[0], paths[1], paths[1]]).standard_errors() is None


def test_the_jackknife_gives_the_error_of_a_mean() -> None:
    """Of a mean over single values it is s / sqrt(n); the mean distance of three pairs is such a mean here."""
    found = PathSet([walk(seed) for seed in range(3)])
    pairs = [found.diversity(pair).dtw_mean for pair in ([0, 1], [0, 2], [1, 2])]
    error = found.standard_errors()
    assert error is not None
    expected = np.sqrt(2 / 3 * np.square(np.array(pairs) - np.mean(pairs)).sum())
    assert error.dtw_mean == pytest.approx(float(expected))


def test_three_paths_say_nothing_about_the_error_of_the_variance() -> None:
    """Without one of three, a single distance is left: ± 0.000 stood there."""
    found = PathSet([walk(seed) for seed in range(4)])
    three, four = found.standard_errors([0, 1, 2]), found.standard_errors()
    assert three is not None and four is not None
    assert named(three)["dtw_variance"] is None and three.dtw_mean > 0 < four.dtw_variance


def test_options_change_what_they_name() -> None:
    paths = [walk(seed) for seed in range(3)]
    usual = PathSet(paths).diversity()
    short = PathSet(paths, DiversityOptions(points=10)).diversity()
    wide = PathSet(paths, DiversityOptions(bandwidth=0.5, rbf_width=2.0)).diversity()
    assert short.dtw_mean < usual.dtw_mean and short.entropy == usual.entropy
    assert wide.entropy > usual.entropy and wide.coverage < usual.coverage and wide.dtw_mean == usual.dtw_mean
