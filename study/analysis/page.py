"""The report of a study as one HTML page: no script, nothing from the network."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from markupsafe import Markup

from movingout.recordings.html_page import templates
from movingout.recordings.report import svg
from movingout.study.analysis import tables
from movingout.study.analysis.likert import VALUES, likert_bars
from movingout.study.analysis.results import STORED, Results
from movingout.study.analysis.tables import HEADS, Namer, ReportTable
from movingout.study.questionnaire import QuestionnaireItem
from movingout.world.estimates import estimate

SIMULATED = "Rehearsal: the participants were simulated. Nothing here says anything about people."
LIKERT_ENDS = {1: "strongly disagree", 4: "neutral", 7: "strongly agree"}


class MetricChart(NamedTuple):
    """A metric by map and partner."""

    heading: str
    picture: Markup


class RatingChart(NamedTuple):
    """How one item was rated."""

    item: QuestionnaireItem
    picture: Markup


def all_tables(results: Results, name: Namer) -> list[ReportTable]:
    """Every table of the report, in its order."""
    return [
        tables.flow(results),
        tables.performance(results, name),
        tables.performance_by_map(results, name),
        tables.metric_comparisons(results, name),
        tables.ratings(results, name),
        tables.rating_comparisons(results, name),
        tables.order_effects(results),
        *([tables.pings(results, name), tables.pings_by_participant(results)] if results.pings else []),
        tables.flags(results),
    ]


def page(results: Results, name: Namer, about: str, simulated: bool = False) -> str:
    """The whole page; `about` says what the study was run with, `simulated` whether nobody real took part."""
    return (
        templates(Path(__file__).parent)
        .get_template("report.html.j2")
        .render(
            title=f"{'Rehearsal: ' if simulated else ''}Results of {results.study.title.text()}",
            warning=SIMULATED if simulated else "",
            tables={table.name: table for table in all_tables(results, name)},
            partners=[name(one) for one in results.partners],
            charts=list(_charts(results, name)),
            ratings=list(_ratings(results, name)),
            likert=[(value, LIKERT_ENDS.get(value, "")) for value in VALUES],
            texts=results.texts(),
            name=name,
            about=about,
            legend_mark=svg.legend_mark,
        )
    )


def _charts(results: Results, name: Namer) -> Iterator[MetricChart]:
    """A chart per metric: maps down, partners as marks, with standard errors."""
    for metric in STORED:
        rows = [(map_name, list(_dots(results, metric.key, map_name, name))) for map_name in results.maps]
        ends = [value for _, row in rows for dot in row for value in (dot.mean - dot.half, dot.mean + dot.half)]
        if ends:
            low = min(0.0, *ends) if metric.low is None else metric.low
            high = max(1.0, *ends) if metric.high is None else metric.high
            title = f"{HEADS[metric.key]} by map, mean and standard error"
            yield MetricChart(HEADS[metric.key], svg.dots(rows, low, high, title))


def _dots(results: Results, metric: str, map_name: str, name: Namer) -> Iterator[svg.Dot]:
    for at, partner in enumerate(results.partners):
        if (found := estimate(results.values(metric, partner, map_name))) is not None:
            title = f"{name(partner)} on {map_name}: {found.mean:.3f}, n = {found.n}"
            yield svg.Dot(at, found.mean, found.stderr or 0.0, title)


def _ratings(results: Results, name: Namer) -> Iterator[RatingChart]:
    """A figure per Likert item: a bar per partner."""
    partners = (*results.partners, *([""] if "" not in results.partners else []))
    for form, item in results.scales():
        rows: list[tuple[str, Sequence[int]]] = []
        for partner in partners:
            values = [round(value) for value in results.ratings(form, item.id, partner).values()]
            if values and item.kind == "likert7":
                rows.append((name(partner) if partner else "(all)", values))
        if rows:
            yield RatingChart(item, likert_bars(rows, f"{item.label}: distribution of ratings by partner"))
