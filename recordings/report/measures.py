"""The measures that a report shows: what they are called, their units, and how a mean of one is written."""

from dataclasses import dataclass

from movingout.world.estimates import Estimate
from movingout.world.metrics import METRICS, Metric


@dataclass(frozen=True, slots=True)
class Measure:
    """How a measure is shown; its scale is None where it follows from the values."""

    name: str
    short: str
    unit: str
    scale: tuple[float, float] | None
    digits: int

    @property
    def heading(self) -> str:
        """The short name with its unit."""
        return self.short + (f", {self.unit}" if self.unit else "")


def _measure(metric: Metric) -> Measure:
    scale = None if metric.low is None or metric.high is None else (metric.low, metric.high)
    return Measure(metric.title, metric.symbol, metric.unit, scale, metric.digits)


MEASURES = {
    "success": Measure("Everything delivered", "Success", "%", (0.0, 100.0), 0),
    "seconds": Measure("Time played", "Time", "s", None, 1),
    **{metric.key: _measure(metric) for metric in METRICS},
}


def in_words(found: Estimate | None, name: str) -> str:
    """A mean as plain text, with its unit."""
    if found is None:
        return "–"
    measure = MEASURES[name]
    number = _number(found.mean, measure)
    return f"{number} {measure.unit}".rstrip()


def with_error(found: Estimate | None, measure: Measure) -> str:
    """A mean with its standard error, for a table."""
    if found is None:
        return "–"
    error = "" if found.stderr is None else f" <small>± {_number(found.stderr, measure)}</small>"
    return f"{_number(found.mean, measure)}{' %' if measure.unit == '%' else ''}{error}"


def _number(value: float, measure: Measure) -> str:
    return f"{value * (100.0 if measure.unit == '%' else 1.0):.{measure.digits}f}".replace("-", "−")
