"""The report of a study as one HTML page: no script, nothing from the network."""

from collections.abc import Sequence
from html import escape
from importlib.resources import files

from movingout.recordings.report import svg
from movingout.study.analysis import tables
from movingout.study.analysis.likert import VALUES, likert_bars
from movingout.study.analysis.results import STORED, Results
from movingout.study.analysis.tables import HEADS, Namer, Table
from movingout.world.estimates import estimate
from movingout.world.metrics import Metric

_ENDS = {1: " strongly disagree", 4: " neutral", 7: " strongly agree"}


def all_tables(results: Results, name: Namer) -> list[Table]:
    """Every table of the report, in its order."""
    return [
        tables.flow(results),
        tables.performance(results, name),
        tables.performance_by_map(results, name),
        tables.metric_comparisons(results, name),
        tables.ratings(results, name),
        tables.rating_comparisons(results, name),
        tables.order_effects(results),
        tables.flags(results),
    ]


SIMULATED = "Rehearsal: the participants were simulated. Nothing here says anything about people."


def page(results: Results, name: Namer, about: str, simulated: bool = False) -> str:
    """The whole page; `about` says what the study was run with, `simulated` whether nobody real took part."""
    title = f"{'Rehearsal: ' if simulated else ''}Results of {results.study.title.text()}"
    warning = f'<p class="simulated" role="note">{SIMULATED}</p>\n' if simulated else ""
    by_name = {table.name: table for table in all_tables(results, name)}
    order = [
        _table(by_name["flow"]),
        _table(by_name["performance"]),
        _charts(results, name),
        _table(by_name["performance_by_map"]),
        _table(by_name["metric_comparisons"]),
        _likert(results, name),
        _table(by_name["ratings"]),
        _table(by_name["rating_comparisons"]),
        _table(by_name["order_effects"]),
        _texts(results, name),
        _table(by_name["flags"]),
        f'<p class="quiet small">{escape(about)}</p>',
    ]
    css = files("movingout.recordings.report").joinpath("page.css").read_text(encoding="utf-8")
    css += files("movingout.study.analysis").joinpath("report.css").read_text(encoding="utf-8")
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
        f"<style>\n{css}</style>\n</head>\n<body>\n<main>\n<header><h1>{escape(title)}</h1></header>\n"
        + warning
        + "\n".join(order)
        + "\n</main>\n</body>\n</html>\n"
    )


def _table(table: Table) -> str:
    heading = f"<h2>{escape(table.title)}</h2>"
    if not table.rows:
        return f'<section aria-label="{escape(table.title)}">{heading}<p class="card">Nothing to show.</p></section>'
    heads = "".join(f'<th scope="col"{_side(table, at)}>{escape(head)}</th>' for at, head in enumerate(table.heads))
    rows = "".join(f"<tr>{_cells(table, row)}</tr>" for row in table.rows)
    note = f'<p class="quiet small">{escape(table.note)}</p>' if table.note else ""
    return (
        f'<section aria-label="{escape(table.title)}">{heading}<div class="card scroll" tabindex="0" role="region" '
        f'aria-label="{escape(table.title)}, table"><table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody>'
        f"</table></div>{note}</section>"
    )


def _cells(table: Table, row: Sequence[str]) -> str:
    return "".join(f"<td{_side(table, at)}>{escape(cell)}</td>" for at, cell in enumerate(row))


def _side(table: Table, column: int) -> str:
    return ' class="words"' if column < table.words else ""


def _charts(results: Results, name: Namer) -> str:
    """A chart per metric: maps down, partners as marks, with standard errors."""
    keys = "".join(f"<li>{svg.legend_mark(at)}{escape(name(one))}</li>" for at, one in enumerate(results.partners))
    charts = "".join(_chart(results, metric, name) for metric in STORED)
    return f'<ul class="legend" aria-label="Partners">{keys}</ul><div class="charts">{charts}</div>' if charts else ""


def _chart(results: Results, metric: Metric, name: Namer) -> str:
    rows: list[tuple[str, list[svg.Dot]]] = []
    for map_name in results.maps:
        dots = []
        for at, partner in enumerate(results.partners):
            if (found := estimate(results.values(metric.key, partner, map_name))) is not None:
                title = f"{name(partner)} on {map_name}: {found.mean:.3f}, n = {found.n}"
                dots.append(svg.Dot(at, found.mean, found.stderr or 0.0, title))
        rows.append((map_name, dots))
    ends = [value for _, row in rows for dot in row for value in (dot.mean - dot.half, dot.mean + dot.half)]
    if not ends:
        return ""
    low = min(0.0, *ends) if metric.low is None else metric.low
    high = max(1.0, *ends) if metric.high is None else metric.high
    title = f"{HEADS[metric.key]} by map, mean and standard error"
    return f'<figure class="card"><h3>{HEADS[metric.key]}</h3>{svg.dots(rows, low, high, title)}</figure>'


def _likert(results: Results, name: Namer) -> str:
    """A figure per Likert item: a bar per partner."""
    figures = []
    for form, item in results.scales():
        rows = []
        for partner in (*results.partners, *([""] if "" not in results.partners else [])):
            values = [round(value) for value in results.ratings(form, item.id, partner).values()]
            if values and item.kind == "likert7":
                rows.append((name(partner) if partner else "(all)", values))
        if rows:
            drawn = likert_bars(rows, f"{item.label}: distribution of ratings by partner")
            figures.append(
                f'<figure class="card"><h3>{escape(item.label)}</h3><p class="quiet small">{escape(item.text)}</p>'
                f"{drawn}</figure>"
            )
    if not figures:
        return ""
    keys = "".join(f'<li><i class="k{value}"></i>{value}{_ENDS.get(value, "")}</li>' for value in VALUES)
    return f'<h2>Ratings by item</h2><ul class="keys">{keys}</ul><div class="charts">{"".join(figures)}</div>'


def _texts(results: Results, name: Namer) -> str:
    quotes = "".join(
        f'<blockquote>{escape(row["text"])}<br><span class="quiet small">{escape(row["pid"])}'
        f"{' about ' + escape(name(row['partner'])) if row['partner'] else ''}</span></blockquote>"
        for row in results.texts()
    )
    folded = f"<details><summary>{len(results.texts())} texts</summary>{quotes}</details>" if quotes else ""
    return f'<section aria-label="Free text"><h2>Free text</h2>{folded or "<p>Nobody wrote anything.</p>"}</section>'
