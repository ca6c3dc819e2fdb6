"""The measures of a report: names, units, and how a mean is written."""

from dataclasses import dataclass

from movingout.world.estimates import Estimate
from movingout.world.metrics import METRICS, Metric


@dataclass(frozen=True, slots=True)
class MeasureDisplay:
    """How a measure is shown; `scale` is None where it follows from the values."""

    name: str
    short: str
    unit: str
    scale: tuple[float, float] | None
    digits: int

    @property
    def heading(self) -> str:
        """The short name with its unit."""
        return self.short + (f", {self.unit}" if self.unit else "")

    def number(self, value: float) -> str:
        """A value as text, in per cent where that is the unit."""
        return f"{value * (100.0 if self.unit == '%' else 1.0):.{self.digits}f}".replace("-", "−")


def _measure(metric: Metric) -> MeasureDisplay:
    scale = None if metric.low is None or metric.high is None else (metric.low, metric.high)
    return MeasureDisplay(metric.title, metric.symbol, metric.unit, scale, metric.digits)


MEASURES = {
    "success": MeasureDisplay("Everything delivered", "Success", "%", (0.0, 100.0), 0),
    "seconds": MeasureDisplay("Time played", "Time", "s", None, 1),
    **{metric.key: _measure(metric) for metric in METRICS},
}


def in_words(found: Estimate | None, name: str) -> str:
    """A mean as plain text, with its unit."""
    if found is None:
        return "–"
    measure = MEASURES[name]
    return f"{measure.number(found.mean)} {measure.unit}".rstrip()
