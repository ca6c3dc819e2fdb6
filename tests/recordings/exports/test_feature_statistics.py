"""Statistics of a stream are those of the whole, in parts of any length."""

import numpy as np

from movingout.recordings.exports.feature_statistics import (
    STEPS,
    RunningStatistics,
    Statistics,
    feature_statistics,
    streamed,
)

WHOLE = np.random.default_rng(3).normal(1e6, [1.0, 0.0, 30.0], (5000, 3))


def parts_of(values: np.ndarray, *at: int) -> list[np.ndarray]:
    return np.split(values, at)


def streamed_in(parts: list[np.ndarray]) -> Statistics:
    moments = RunningStatistics()
    for part in parts:
        moments.add(part)
    return streamed({"x": moments}, ({"x": part} for part in parts))["x"]


def test_one_array_has_the_statistics_that_numpy_computes() -> None:
    found = feature_statistics(WHOLE)
    np.testing.assert_allclose(found["mean"], WHOLE.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(found["std"], WHOLE.std(axis=0), rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(found["q90"], np.quantile(WHOLE, 0.9, axis=0))
    assert (found["min"], found["max"], found["count"]) == (
        WHOLE.min(axis=0).tolist(), WHOLE.max(axis=0).tolist(), [5000],
    )  # fmt: skip


def test_a_stream_has_the_statistics_of_the_whole_and_quantiles_to_a_step() -> None:
    found, whole = streamed_in(parts_of(WHOLE, 1, 2, 700, 4999)), feature_statistics(WHOLE)
    for name in ("min", "max", "mean", "count"):
        np.testing.assert_allclose(found[name], whole[name], rtol=1e-12)
    np.testing.assert_allclose(found["std"], whole["std"], rtol=1e-9, atol=1e-9)
    step = (WHOLE.max(axis=0) - WHOLE.min(axis=0)) / (STEPS - 1)
    for name, quantile in (("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)):
        value = np.quantile(WHOLE, quantile, axis=0, method="lower")
        assert (np.abs(found[name] - value) <= 0.5001 * step).all(), name


def test_numbers_with_few_values_have_one_of_them_as_quantile() -> None:
    grasps = np.zeros(1000, dtype=bool)
    grasps[::20] = True
    found = streamed_in(parts_of(grasps, 400))
    assert [found[name] for name in ("q10", "q50", "q90", "q99")] == [[0.0], [0.0], [0.0], [1.0]]
    assert (found["mean"], found["min"], found["max"]) == ([0.05], [0.0], [1.0])
