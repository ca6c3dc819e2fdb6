"""What is written from the table of metrics is current."""

import json

import pytest

from bench.source import metric_pages
from movingout.world.metrics import METRICS


def test_the_table_and_the_plots_are_current() -> None:
    for file, made in ((metric_pages.PAGE, metric_pages.page), (metric_pages.LAYOUT, metric_pages.layout)):
        text = file.read_text(encoding="utf-8")
        assert made(text) == text, "run: make generate"


def test_a_further_metric_gets_a_line_and_a_plot(monkeypatch: pytest.MonkeyPatch) -> None:
    share = METRICS[0]
    distance = type(share)(
        key="walked", symbol="DIST", title="Distance walked", unit="m", low=0.0, high=None, higher_is_better=False,
        digits=1, meaning="way of both | robots", none_when="nobody moved", from_paper=False,
    )  # fmt: skip
    monkeypatch.setattr(metric_pages, "METRICS", (share, distance))
    page = metric_pages.page(metric_pages.PAGE.read_text(encoding="utf-8"))
    assert "| DIST, distance walked (`walked`) | way of both \\| robots; none when nobody moved | – |\n" in page
    panels = json.loads(metric_pages.layout(metric_pages.LAYOUT.read_text(encoding="utf-8")))["configById"]
    labels = {name: [path["label"] for path in panels[name]["paths"]] for name in ("Plot!shares", "Plot!amounts")}
    assert labels == {"Plot!shares": ["TCR"], "Plot!amounts": ["DIST [m] (-1: none)"]}
