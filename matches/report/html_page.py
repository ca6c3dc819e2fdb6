"""The tournament view: one offline HTML page with heat maps, marks of significance and the worst matches."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from movingout.matches.match import MatchResult
from movingout.matches.report.crossplay import Cell, Matrix, matrix, moments, worst_matches
from movingout.matches.results.results_folder import write_whole
from movingout.matches.results.significance import stars
from movingout.matches.results.table import MEASURES, copies_note
from movingout.matches.run import GridRun
from movingout.recordings.commands.report import SERVER
from movingout.recordings.html_page import templates
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.estimates import estimate_text

STRONGEST = 45  # % of colour in the best cell: dark ink stays readable on it


class Section(NamedTuple):
    """The matrices of one condition, challenge and map."""

    title: str
    folded: bool  # single maps, when there is a section over all maps
    matrices: tuple[Matrix, ...]


class Place(NamedTuple):
    """Where to look in a match, with a link to the replay where there is one."""

    link: str
    tick: int
    text: str


def write_page(run: GridRun) -> None:
    """Write results.html into the results folder. Raises MatchError."""
    write_whole(run.folder / "results.html", page(run))


def page(run: GridRun) -> str:
    """The whole document; nothing in it comes from elsewhere."""
    return (
        templates(Path(__file__).parent)
        .get_template("crossplay.html.j2")
        .render(
            run=run,
            title=run.grid.name,
            figures=_figures(run),
            sections=list(_sections(run)),
            measures=MEASURES,
            worst=[(result, list(_places(run, result))) for result in worst_matches(run)],
            recorded=any(result.recording for result in run.results.values()),
            estimate_text=estimate_text,
            notes=copies_note(run.rows),
            stars=stars,
            strength=_strength,
            tip=_tip,
        )
    )


def _figures(run: GridRun) -> list[tuple[str, int, str]]:
    """Name, number and note of each figure at the top."""
    results = list(run.results.values())
    seconds = run.grid.ticks / TICKS_PER_SECOND
    return [
        ("Matches", len(results), f"of {len(results) + run.missing} in the grid"),
        ("Everything delivered", sum(result.ending == "delivered" for result in results), "matches"),
        ("Lost to an error", len(run.failures), "count as nothing delivered"),
        ("Seeds", len(run.grid.seed_range), f"{len(run.grid.map_list)} maps, {seconds:g} s at most"),
    ]


def _sections(run: GridRun) -> Iterator[Section]:
    rows = run.rows
    for (condition, challenge, name), group in groupby(rows, lambda row: (row.condition, row.challenge, row.map)):
        cells = list(group)
        title = f"{name} · {condition} · Challenge {challenge}"
        yield Section(title, name != rows[0].map, tuple(matrix(cells, measure) for measure in MEASURES))


def _strength(found: Matrix, cell: Cell) -> int:
    """How much colour a cell has, in %."""
    return round(STRONGEST * found.strength(cell.estimate))


def _tip(cell: Cell) -> str:
    count = 0 if cell.estimate is None else cell.estimate.n
    copies = "" if cell.distinct is None or cell.distinct >= count else f" ({cell.distinct} distinct)"
    return f"n = {count}{copies}" + ("" if cell.p is None else f", p = {cell.p:.2g} against the best")


def _places(run: GridRun, result: MatchResult) -> Iterator[Place]:
    episode = quote(Path(result.recording).name.removesuffix(SUFFIX), safe="")
    for moment in moments(run, result):
        link = f"{SERVER}/replay/{episode}#tick={moment.tick}" if result.recording else ""
        yield Place(link, moment.tick, moment.text)
