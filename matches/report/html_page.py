"""The tournament view: one offline HTML page with heat maps, marks of significance and the worst matches."""

from html import escape
from importlib import resources
from itertools import groupby
from pathlib import Path
from urllib.parse import quote

from movingout.matches.match import MatchResult
from movingout.matches.report.crossplay import Cell, Matrix, Moment, matrix, moments, worst_matches
from movingout.matches.results.results_folder import write_whole
from movingout.matches.results.significance import stars
from movingout.matches.results.table import MEASURES, Row, html
from movingout.matches.run import GridRun
from movingout.recordings.commands.report import SERVER
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.estimates import estimate_text

_SHARE = 45  # % of colour in the best cell: dark ink stays readable on it


def write_page(run: GridRun) -> None:
    """Write results.html into the results folder. Raises MatchError."""
    write_whole(run.folder / "results.html", page(run))


def page(run: GridRun) -> str:
    """The whole document; nothing in it comes from elsewhere."""
    body = "\n".join([_head(run), _problems(run), *_matrices(run), _worst(run), _table(run)])
    styles = _text("movingout.recordings.report", "page.css") + _text("movingout.matches.report", "crossplay.css")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(run.grid.name)}</title>\n<style>\n{styles}</style>\n</head>\n"
        f"<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _text(package: str, name: str) -> str:
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")


def _head(run: GridRun) -> str:
    results = list(run.results.values())
    full = sum(result.ending == "delivered" for result in results)
    figures = (
        ("Matches", str(len(results)), f"of {len(results) + run.missing} in the grid"),
        ("Everything delivered", str(full), "matches"),
        ("Lost by a fault", str(len(run.failures)), "count as nothing delivered"),
        (
            "Seeds",
            str(len(run.grid.seed_range)),
            f"{len(run.grid.map_list)} maps, {run.grid.ticks / TICKS_PER_SECOND:g} s at most",
        ),
    )
    cards = "".join(
        f'<div class="card"><span class="quiet small">{name}</span><strong>{value}</strong>'
        f'<span class="quiet small">{note}</span></div>'
        for name, value, note in figures
    )
    about = f'<p class="quiet">{escape(run.grid.about.strip())}</p>' if run.grid.about else ""
    return (
        f"<header><h1>{escape(run.grid.name)}</h1>{about}</header>\n"
        f'<section class="figures" aria-label="At a glance">{cards}</section>'
    )


def _problems(run: GridRun) -> str:
    if not run.missing:
        return ""
    return f'<section class="notice">Incomplete: {run.missing} matches have not been played yet.</section>'


def _matrices(run: GridRun) -> list[str]:
    """A section per condition, challenge and map; single maps folded away when there is one over all."""
    parts = [
        '<h2>Who with whom</h2><p class="quiet small">Rows: the agent that is evaluated. Columns: its partner. '
        "Mean ± standard error, n in the tip of each cell. Bold: the best with that partner. Marks: worse than that, "
        "Welch's test with Holm's correction in the column: * p &lt; 0.05, ** p &lt; 0.01, *** p &lt; 0.001.</p>"
    ]
    for (condition, challenge, name), group in groupby(run.rows, lambda row: (row.condition, row.challenge, row.map)):
        rows = list(group)
        title = f"{name} · {condition} · Challenge {challenge}"
        cards = "".join(_card(matrix(rows, measure)) for measure in MEASURES)
        folded = "" if name == run.rows[0].map else "s"
        opening = f"<details><summary>{escape(title)}</summary>" if folded else f"<h3>{escape(title)}</h3>"
        closing = "</details>" if folded else ""
        parts.append(f'<section>{opening}<div class="matrices">{cards}</div>{closing}</section>')
    return parts


def _card(found: Matrix) -> str:
    arrow = "more is better" if found.measure.more_is_better else "less is better"
    top = "".join(f'<th scope="col">{escape(partner)}</th>' for partner in found.partners)
    body = "".join(
        f'<tr><th scope="row">{escape(agent)}</th>'
        + "".join(_cell(found, found.cells.get((agent, partner))) for partner in found.partners)
        + "</tr>"
        for agent in found.agents
    )
    return (
        f'<div class="card"><h4>{found.measure.heading} <span class="quiet small">{arrow}</span></h4>'
        f'<table class="matrix"><thead><tr><th scope="col">agent</th>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _cell(found: Matrix, cell: Cell | None) -> str:
    if cell is None:
        return "<td></td>"
    share = round(_SHARE * found.strength(cell.estimate))
    tip = f"n = {cell.estimate.n if cell.estimate else 0}" + (
        "" if cell.p is None else f", p = {cell.p:.2g} against the best"
    )
    return (
        f'<td{" class=best" if cell.best else ""} title="{tip}" '
        f'style="background: color-mix(in srgb, var(--goal-edge) {share}%, var(--surface))">'
        f"{estimate_text(cell.estimate)}<sup>{stars(cell.p)}</sup></td>"
    )


def _worst(run: GridRun) -> str:
    rows = "".join(_worst_row(run, result) for result in worst_matches(run))
    heads = "".join(f'<th scope="col" class="words">{head}</th>' for head in ("map", "blue", "red", "where to look"))
    hint = (
        f"To open the replay at a tick, start <code>movingout play --data {escape(str(run.folder))}</code> first."
        if any(result.recording for result in run.results.values())
        else "Play the grid with --record into another folder to see where to look in each match."
    )
    return (
        '<h2>Worst matches</h2><p class="quiet small">Those lost by a fault, then the worst of each pairing in turn. '
        f'{hint}</p><div class="card scroll"><table><thead><tr>{heads}'
        '<th scope="col">seed</th><th scope="col">TCR</th><th scope="col">NFD</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _worst_row(run: GridRun, result: MatchResult) -> str:
    match = result.match
    where = [f"{_tick(result, moment)}: {escape(moment.words)}" for moment in moments(run, result)]
    if result.recording:
        where.insert(0, f'<a href="{quote(result.recording)}">{escape(result.recording.rpartition("/")[2])}</a>')
    cells = "".join(f'<td class="words">{escape(text)}</td>' for text in (match.map, match.blue, match.red))
    return (
        f'<tr>{cells}<td class="where">{"<br>".join(where) or "–"}</td>'
        f"<td>{match.seed}</td><td>{result.metrics.tcr:.2f}</td><td>{result.metrics.nfd:.2f}</td></tr>"
    )


def _tick(result: MatchResult, moment: Moment) -> str:
    """The tick, as a link to the replay where there is one."""
    if not result.recording:
        return f"tick {moment.tick}"
    episode = Path(result.recording).name.removesuffix(SUFFIX)
    return f'<a href="{SERVER}/replay/{quote(episode, safe="")}#tick={moment.tick}">tick {moment.tick}</a>'


def _table(run: GridRun) -> str:
    rows: list[Row] = run.rows
    return f'<h2>All figures</h2><div class="card scroll">{html(rows)}</div>'
