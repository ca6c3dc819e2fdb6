"""What is written from the table of metrics: the table in docs/metrics.md and the plots in docs/foxglove-layout.json.

python -m bench.source.metric_pages      writes both anew
"""

import json
from typing import Any

from bench.source.files import ROOT
from movingout.world.metrics import METRICS, NO_VALUE, Metric

PAGE = ROOT / "docs" / "metrics.md"
LAYOUT = ROOT / "docs" / "foxglove-layout.json"
START = "<!-- metrics: written by python -m bench.source.metric_pages -->"
END = "<!-- end of metrics -->"
COLOURS = ("#0072B2", "#009E73", "#CC79A7", "#D55E00", "#E69F00", "#56B4E9", "#666666")  # Okabe and Ito, and a grey


def main() -> None:
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    LAYOUT.write_text(layout(LAYOUT.read_text(encoding="utf-8")), encoding="utf-8")


def page(text: str) -> str:
    """The page with its table made anew."""
    before, _, rest = text.partition(START)
    _, _, after = rest.partition(END)
    head = ["| metric | what | official code under the same name |", "|---|---|---|"]
    return "\n".join([before + START, *head, *(_row(metric) for metric in METRICS), END]) + after


def layout(text: str) -> str:
    """The layout with its two plots of metrics made anew: shares have a common scale, the others none."""
    document: dict[str, Any] = json.loads(text)
    panels = document["configById"]
    shares = [metric for metric in METRICS if _is_share(metric)]
    panels["Plot!shares"]["paths"] = _paths(shares)
    panels["Plot!amounts"]["paths"] = _paths([metric for metric in METRICS if metric not in shares])
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _row(metric: Metric) -> str:
    name = f"{metric.symbol}, {metric.title.lower()} (`{metric.key}`)"
    what = metric.definition or metric.meaning
    if metric.none_when:
        what += f"; none when {metric.none_when}"
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in (name, what, metric.official)) + " |"


def _is_share(metric: Metric) -> bool:
    return not metric.unit and metric.high == 1.0


def _paths(metrics: list[Metric]) -> list[dict[str, Any]]:
    """What a plot shows: a line per metric; where a metric has no value, recordings have NO_VALUE."""
    return [
        {
            "value": f"/metrics.{metric.key}",
            "label": metric.heading + (f" ({NO_VALUE:g}: none)" if metric.none_when else ""),
            "color": COLOURS[index % len(COLOURS)],
            "enabled": True,
            "timestampMethod": "receiveTime",
        }
        for index, metric in enumerate(metrics)
    ]


if __name__ == "__main__":
    main()
