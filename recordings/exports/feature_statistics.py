"""Statistics of each dimension of a feature: exact for one array, and in little memory for a stream of any length."""

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.generic]  # (T,) or (T, D) numbers or truth values
Floats = npt.NDArray[np.float64]
Statistics = dict[str, list[float] | list[int]]
QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
STEPS = 5041  # quantiles of a stream are to half a step of so many over the range; small whole numbers fall on one


def feature_statistics(values: Values) -> Statistics:
    """Minimum, maximum, mean, standard deviation, quantiles, and how many rows there are."""
    rows, moments = _rows(values), RunningStatistics()
    moments.add(values)
    return moments.told(np.quantile(rows, QUANTILES, axis=0))


class RunningStatistics:
    """Row count, range, mean and variance, updated array by array (Chan, Golub and LeVeque 1979)."""

    def __init__(self) -> None:
        self.count = 0
        self.lowest: Floats = np.array(np.inf)
        self.highest: Floats = np.array(-np.inf)
        self._mean: Floats = np.array(0.0)
        self._squares: Floats = np.array(0.0)  # of the distances from the mean

    def add(self, values: Values) -> None:
        rows = _rows(values)
        total, mean = self.count + len(rows), rows.mean(axis=0)
        apart = mean - self._mean
        self._squares = self._squares + ((rows - mean) ** 2).sum(axis=0) + apart**2 * (self.count * len(rows) / total)
        self._mean = self._mean + apart * (len(rows) / total)
        self.lowest = np.minimum(self.lowest, rows.min(axis=0))
        self.highest = np.maximum(self.highest, rows.max(axis=0))
        self.count = total

    def told(self, quantiles: Floats) -> Statistics:
        """As JSON, with the quantiles (Q, D)."""
        return {
            "min": self.lowest.tolist(),
            "max": self.highest.tolist(),
            "mean": self._mean.tolist(),
            "std": np.sqrt(self._squares / self.count).tolist(),
            "count": [self.count],
            **{f"q{round(q * 100):02d}": row.tolist() for q, row in zip(QUANTILES, quantiles, strict=True)},
        }


def streamed(moments: Mapping[str, RunningStatistics], parts: Iterable[Mapping[str, Values]]) -> dict[str, Statistics]:
    """Statistics by feature; `parts` are the values once more, from which quantiles are counted in steps."""
    counts = {name: np.zeros((one.lowest.size, STEPS), dtype=np.int64) for name, one in moments.items()}
    for part in parts:
        for name, one in moments.items():
            counts[name] += _counted(_rows(part[name]), one)
    return {name: one.told(_quantiles(counts[name], one)) for name, one in moments.items()}


def _counted(rows: Floats, moments: RunningStatistics) -> npt.NDArray[np.int64]:
    """(D, STEPS) how many values are nearest to each step."""
    width = moments.highest - moments.lowest
    steps = np.rint((rows - moments.lowest) / np.where(width > 0, width, 1.0) * (STEPS - 1)).astype(np.int64)
    size = rows.shape[1]
    return np.bincount((steps + np.arange(size) * STEPS).ravel(), minlength=size * STEPS).reshape(size, STEPS)


def _quantiles(counts: npt.NDArray[np.int64], moments: RunningStatistics) -> Floats:
    """(Q, D) the step that the value of each rank belongs to."""
    upto = counts.cumsum(axis=1)
    ranks = np.array(QUANTILES) * (moments.count - 1)
    steps = np.array([(upto <= rank).sum(axis=1) for rank in ranks])
    quantiles: Floats = moments.lowest + steps / (STEPS - 1) * (moments.highest - moments.lowest)
    return quantiles


def _rows(values: Values) -> Floats:
    return values.reshape(len(values), -1).astype(np.float64)
