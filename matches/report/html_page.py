"""The tournament view: one offline HTML page with heat maps, marks of significance and the worst matches."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from movingout.matches.grid_run import GridRun
from movingout.matches.match import MatchResult
from movingout.matches.report.crossplay import Cell, Matrix, matrix, moments, worst_matches
from movingout.matches.report.words import count_words, map_name, measure_title, report_words, value_text
from movingout.matches.results.results_folder import write_whole
from movingout.matches.results.significance import stars
from movingout.matches.results.table import MEASURES, copies_note, earlier_note
from movingout.matches.results.unanswered import have_uncounted_questions, unanswered
from movingout.recordings.html_page import SERVER, templates
from movingout.recordings.report.words import DEFAULT, Words
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.constants import TICKS_PER_SECOND

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


def write_page(run: GridRun, language: str = DEFAULT) -> None:
    """Write results.html into the results folder. Raises MatchError."""
    write_whole(run.folder / "results.html", page(run, language))


def page(run: GridRun, language: str = DEFAULT) -> str:
    """The whole document; nothing in it comes from elsewhere."""
    words = report_words(language)
    return (
        templates(Path(__file__).parent)
        .get_template("crossplay.html.j2")
        .render(
            run=run,
            title=run.grid.name,
            say=words.say,
            words=words,
            language=words.language,
            figures=_figures(run, words),
            sections=list(_sections(run, words)),
            measures=MEASURES,
            worst=[(result, list(_places(run, result, words))) for result in worst_matches(run)],
            recorded=any(result.recording for result in run.results.values()),
            value_text=value_text,
            count_words=count_words,
            map_name=map_name,
            measure_title=measure_title,
            notes=_notes(run, words),
            stars=stars,
            strength=_strength,
            tip=lambda cell: _tip(cell, words),
        )
    )


def _notes(run: GridRun, words: Words) -> list[str]:
    mixed = [words.say("grid.mixed-code")] if run.mixed_code else []
    copies = [words.say("grid.copies") for _ in copies_note(run.rows)]
    if found := unanswered(run.results.values()):
        copies.append(words.say("grid.unanswered", **found._asdict()))
    if have_uncounted_questions(run.results.values()):
        copies.append(words.say("grid.uncounted"))
    return [*mixed, *copies, *(words.say("grid.earlier") for _ in earlier_note(run.rows))]


def _figures(run: GridRun, words: Words) -> list[tuple[str, int, str]]:
    """Name, number and note of each figure at the top."""
    results, say = list(run.results.values()), words.say
    delivered = sum(result.ending == "delivered" for result in results)
    limit = words.decimal(f"{run.grid.ticks / TICKS_PER_SECOND:g}")
    return [
        (say("grid.matches"), len(results), say("grid.matches.note", number=len(results) + run.missing)),
        (say("grid.delivered"), delivered, say("grid.delivered.note")),
        (say("grid.lost"), len(run.failures), say("grid.lost.note")),
        (
            say("grid.seeds"),
            len(run.grid.seed_range),
            say("grid.seeds.note", count=len(run.grid.map_list), seconds=limit),
        ),
    ]


def _sections(run: GridRun, words: Words) -> Iterator[Section]:
    rows = run.rows
    for (condition, challenge, name), group in groupby(rows, lambda row: (row.condition, row.challenge, row.map)):
        cells = list(group)
        title = words.say("grid.section", map=map_name(words, name), condition=condition, challenge=str(challenge))
        yield Section(title, name != rows[0].map, tuple(matrix(cells, measure) for measure in MEASURES))


def _strength(found: Matrix, cell: Cell) -> int:
    """How much colour a cell has, in %."""
    return round(STRONGEST * found.strength(cell.estimate))


def _tip(cell: Cell, words: Words) -> str:
    count = 0 if cell.estimate is None else cell.estimate.n
    text = words.say("grid.cell", n=count)
    if cell.distinct is not None and cell.distinct < count:
        text = words.say("grid.cell.distinct", n=count, distinct=cell.distinct)
    return text if cell.p is None else words.say("grid.cell.p", cell=text, p=words.decimal(f"{cell.p:.2g}"))


def _places(run: GridRun, result: MatchResult, words: Words) -> Iterator[Place]:
    episode = quote(Path(result.recording).name.removesuffix(SUFFIX), safe="")
    for moment in moments(run, result, words):
        link = f"{SERVER}/replay/{episode}#tick={moment.tick}" if result.recording else ""
        yield Place(link, moment.tick, moment.text)
