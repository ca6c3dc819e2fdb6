"""The measures of a report: units, scales, and how a mean is written."""

from dataclasses import dataclass

from movingout.recordings.report.words import Words
from movingout.world.estimates import Estimate
from movingout.world.metrics import METRICS, Metric
from movingout.world.own_metrics import own_metrics


@dataclass(frozen=True, slots=True)
class MeasureDisplay:
    """How a measure is shown; `scale` is None where it follows from the values."""

    key: str
    title: str  # where the words of the report have none
    symbol: str
    unit: str
    scale: tuple[float, float] | None
    digits: int

    def name(self, words: Words) -> str:
        return words.known(f"measure.{self.key}", self.title)

    def heading(self, words: Words) -> str:
        """The short name with its unit."""
        return words.known(f"measure.{self.key}.short", self.symbol) + (f", {self.unit}" if self.unit else "")

    def number(self, value: float, words: Words) -> str:
        """A value as text, in per cent where that is the unit."""
        plain = f"{value * (100.0 if self.unit == '%' else 1.0):.{self.digits}f}"
        return words.decimal(plain).replace("-", "−")


def _measure(metric: Metric) -> MeasureDisplay:
    scale = None if metric.low is None or metric.high is None else (metric.low, metric.high)
    return MeasureDisplay(metric.key, metric.title, metric.symbol, metric.unit, scale, metric.digits)


MEASURES = {
    "success": MeasureDisplay("success", "", "", "%", (0.0, 100.0), 0),
    "seconds": MeasureDisplay("seconds", "", "", "s", None, 1),
    **{metric.key: _measure(metric) for metric in (*METRICS, *own_metrics())},
}


def in_words(found: Estimate | None, name: str, words: Words) -> str:
    """A mean as plain text, with its unit."""
    if found is None:
        return "–"
    measure = MEASURES[name]
    return f"{measure.number(found.mean, words)} {measure.unit}".rstrip()
