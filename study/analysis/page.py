"""The report of a study as one HTML page: no script, nothing from the network."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from markupsafe import Markup

from movingout.recordings.html_page import templates
from movingout.recordings.report import svg
from movingout.recordings.report.words import Words
from movingout.study.analysis import paper_tables, tables
from movingout.study.analysis.likert import VALUES, likert_bars
from movingout.study.analysis.questions import AskedItem, counted_items, rated_items
from movingout.study.analysis.results import STORED, Results
from movingout.study.analysis.tables import ENGLISH, HEADS, Namer, ReportTable
from movingout.study.questionnaire import LIKERT_MAX, LIKERT_MIN, NO_ANSWER, QuestionnaireItem
from movingout.world.estimates import estimate


class MetricChart(NamedTuple):
    """A metric by map and partner."""

    heading: str
    picture: Markup


class RatingChart(NamedTuple):
    """How one item was rated."""

    heading: str
    text: str  # of the question
    ends: str  # what 1 and 7 mean, where it is not the usual
    picture: Markup


def all_tables(results: Results, name: Namer, words: Words = ENGLISH) -> list[ReportTable]:
    """Every table of the report, in its order."""
    return [
        tables.flow(results, words),
        tables.performance(results, name, words),
        *([table] if (table := paper_tables.paper_table(results, name, words)) else []),
        tables.performance_by_map(results, name, words),
        tables.metric_comparisons(results, name, words),
        tables.ratings(results, name, words),
        paper_tables.rating_table(results, name, words),
        *([tables.choices(results, name, words)] if counted_items(results.study) else []),
        tables.order_effects(results, words),
        *([tables.pings(results, name, words), tables.pings_by_participant(results, words)] if results.pings else []),
        *_failure_tables(results, name, words),
        tables.flags(results, words),
    ]


def _failure_tables(results: Results, name: Namer, words: Words) -> list[ReportTable]:
    """Where partners failed, as far as there are recordings; what annotators said, as soon as one has."""
    if not results.sessions.sessions:
        return []
    said = [paper_tables.annotation_table(results, words), paper_tables.agreement_table(results, words)]
    return [paper_tables.failure_table(results, name, words), *(said if results.sessions.verdicts else [])]


def page(results: Results, name: Namer, about: str, words: Words = ENGLISH, simulated: bool = False) -> str:
    """The whole page; `about` says what the study was run with, `simulated` whether nobody real took part."""
    title, rated = results.study.title.text(words.language), list(_ratings(results, name, words))
    usual = any(not chart.ends for chart in rated)
    return (
        templates(Path(__file__).parent)
        .get_template("report.html.j2")
        .render(
            words=words,
            say=words.say,
            language=words.language,
            title=words.say("study.title.simulated" if simulated else "study.title", study=title),
            simulated=simulated,
            tables={table.name: table for table in all_tables(results, name, words)},
            partners=[name(one) for one in results.partners],
            charts=list(_charts(results, name, words)),
            ratings=rated,
            likert=[(one, words.known(f"study.likert.{one}", str(one)) if usual else str(one)) for one in VALUES],
            texts=results.texts(),
            name=name,
            about=about,
            legend_mark=svg.legend_mark,
        )
    )


def _charts(results: Results, name: Namer, words: Words) -> Iterator[MetricChart]:
    """A chart per metric and blocks that may be pooled: maps down, partners as marks, with standard errors."""
    for metric in STORED:
        for label, part in results.by_condition():
            rows = [(one, list(_dots(results.partners, part, metric.key, one, name, words))) for one in part.maps]
            ends = [value for _, row in rows for dot in row for value in (dot.mean - dot.half, dot.mean + dot.half)]
            if ends:
                low = min(0.0, *ends) if metric.low is None else metric.low
                high = max(1.0, *ends) if metric.high is None else metric.high
                heading = _heading(HEADS[metric.key], label)
                title = words.say("study.chart", measure=heading)
                yield MetricChart(heading, svg.dots(rows, low, high, title, words.decimal))


def _heading(measure: str, blocks: str) -> str:
    return f"{measure} ({blocks})" if blocks else measure


def _dots(
    partners: Sequence[str], results: Results, metric: str, map_name: str, name: Namer, words: Words
) -> Iterator[svg.Dot]:
    for at, partner in enumerate(partners):
        if (found := estimate(results.values(metric, partner, map_name))) is not None:
            mean = words.decimal(f"{found.mean:.3f}")
            title = words.say("study.chart.dot", partner=name(partner), map=map_name, mean=mean, n=found.n)
            yield svg.Dot(at, found.mean, found.stderr or 0.0, title)


def _ratings(results: Results, name: Namer, words: Words) -> Iterator[RatingChart]:
    """A figure per Likert item and blocks that may be pooled: a bar of all answers per partner."""
    for rated in rated_items(results.study, words.language):
        for label, part in results.by_condition_asked():
            rows = list(_bars(part, rated, name, words)) if rated.item.kind == "likert7" else []
            if rows:
                heading = _heading(rated.label, label)
                title = words.say("study.ratings.figure", item=heading)
                yield RatingChart(heading, rated.item.text, _ends(rated.item), likert_bars(rows, title, words))


def _ends(item: QuestionnaireItem) -> str:
    return f"{LIKERT_MIN} {item.ends[0]} – {LIKERT_MAX} {item.ends[1]}" if any(item.ends) else ""


def _bars(results: Results, rated: AskedItem, name: Namer, words: Words) -> Iterator[tuple[str, Sequence[int]]]:
    for partner in (*results.rated_partners, None):
        counts = results.counts(rated.questionnaire, rated.item.id, partner, rated.occasions)
        values = [value for value in counts.elements() if value != NO_ANSWER]
        if values:
            label = words.say("study.ratings.at_end") if partner is None else name(partner)
            yield label, values
