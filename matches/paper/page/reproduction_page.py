"""The measured part of docs/reproduction.md: a row for every label of the paper, and below them all tables in full.

Written between two comments of the page; what stands around them is kept. So are the numbers of a label that the page
has with a bigger budget, whole, with more trainings or with more numbers than the folder (`PageLabel.is_better_than`),
and the day of numbers that stay the same. Numbers that were measured otherwise than today (`PaperEntry.earlier`) give
way to as whole a measurement with the same budget, whatever n. Words are always those of today. Sizes of data sets are
a definition here, those of scripted people, whatever recordings the folder was given.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from movingout.matches.errors import MatchError
from movingout.matches.paper.cells import EmptyCell, Found
from movingout.matches.paper.costs import span
from movingout.matches.paper.entry import EntryCell, PaperEntry, played_cells
from movingout.matches.paper.given_players import given_players
from movingout.matches.paper.page.page_labels import (
    DRAWN,
    HEADS,
    IN_PART,
    MEASURED,
    TRAININGS,
    PageLabel,
    line,
    written_labels,
)
from movingout.matches.paper.page.wording import is_of_earlier, reworded, section
from movingout.matches.paper.presentation.layout import column_head, laid_out, number_text, paper_text
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.rows.data_sizes import SizeCell
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.workspace import Workspace
from movingout.matches.results.results_folder import write_whole

BEGIN, END = "<!-- measured: written by movingout paper page -->", "<!-- end of what is measured -->"


def write_page(page: Path, entries: Iterable[PaperEntry], space: Workspace, day: str) -> None:
    """Bring the page up to date with the workspace. Raises MatchError for a page without the two comments."""
    try:
        text = page.read_text(encoding="utf-8")
    except OSError as error:
        raise MatchError(f"cannot read {page}: {error.strerror or error}") from error
    before, begin, rest = text.partition(BEGIN)
    earlier, end, after = rest.partition(END)
    if not begin or not end:
        raise MatchError(f"{page} has no place to write to: it needs the lines {BEGIN} and {END}")
    measured = _measured(list(entries), space, day, written_labels(earlier))
    write_whole(page, before + BEGIN + "\n" + measured + END + after)


def _measured(entries: list[PaperEntry], space: Workspace, day: str, earlier: Mapping[str, PageLabel]) -> str:
    shown = [entry for entry in entries if entry.kind != "illustration" or entry.differs]
    tables, players = _in_full(shown, space), given_players(space)
    labels = []
    for entry in shown:
        now = PageLabel(line(_row(entry, _shown_in(entry, space), day, players)), tables.get(entry.label, ""))
        then = earlier.get(entry.label)
        if then is not None and then.has_numbers:
            kept = reworded(then, entry, space, _differs(entry, list(entry.cells())))
            now = now if _is_outdated(then, now, entry) else _better(kept, now)
        labels.append(now)
    head = "`movingout paper tables LABEL --budget` and the budget of the row; for figures `paper figures LABEL`."
    rows = [line(HEADS), line(["---"] * len(HEADS)), *(one.row for one in labels)]
    return "\n".join([head, "", *rows, "", "## All numbers", "", *(one.table for one in labels if one.table), ""])


def _shown_in(entry: PaperEntry, space: Workspace) -> Workspace:
    """The folder; for sizes of data sets as it would be without given recordings."""
    return replace(space, given=()) if any(isinstance(cell.ours, SizeCell) for cell in entry.cells()) else space


def _is_outdated(then: PageLabel, now: PageLabel, entry: PaperEntry) -> bool:
    """Whether only `then` was measured otherwise than today, and `now` as whole: then n may count something else."""
    return now.is_as_whole_as(then) and is_of_earlier(then, entry) and not is_of_earlier(now, entry)


def _better(then: PageLabel, now: PageLabel) -> PageLabel:
    """What is better, or of the day on which it was measured: numbers that have not changed keep theirs."""
    return then if then.is_better_than(now) or (now.has_numbers and then.has_numbers_of(now)) else now


def _row(entry: PaperEntry, space: Workspace, day: str, players: str) -> tuple[str, ...]:
    """`players`: who played what was learned from, where it was given."""
    cells = list(entry.cells())
    found = [(cell, cell.ours.found(space)) for cell in cells]
    measured = [(cell, one) for cell, one in found if one is not None]
    made = any(one.defined is None for _, one in measured) or entry.drawn()
    spent = _seconds(entry, space) if made else 0.0
    whose = "" if entry.own_episodes else players
    return (
        f"`{entry.label}`", _status(entry, found), _made_with(measured, space, day, whose) if made else "–",
        "<br>".join(_headline(measured)) or "–", _counts(measured), span(spent) if spent else "–",
        _differs(entry, cells),
    )  # fmt: skip


def _made_with(measured: list[tuple[EntryCell, Found]], space: Workspace, day: str, players: str) -> str:
    trainings = max((one.between.n for _, one in measured if one.between), default=1)
    several = f", {trainings} {TRAININGS}" if trainings > 1 else ""
    return f"{space.budget.name}, {day}" + several + (f", {players}" if players else "")


def _status(entry: PaperEntry, found: list[tuple[EntryCell, Found | None]]) -> str:
    if entry.kind == "illustration":
        return "nothing is measured"
    if entry.drawing:
        return DRAWN if entry.drawn() else "not drawn yet"
    ours = [one for cell, one in found if not isinstance(cell.ours, EmptyCell)]
    if _is_defined(found):
        return "a definition"
    if any(one is not None and one.defined is None for one in ours):
        missing = bool(entry.lacks) or any(one is None and not cell.without_number for cell, one in found)
        return IN_PART if missing else MEASURED
    if ours:
        return "not measured with this budget"
    return "needs people" if entry.people else "another command" if entry.command else "not built"


def _is_defined(found: list[tuple[EntryCell, Found | None]]) -> bool:
    """Whether an entry is of settings alone, which no budget changes."""
    return bool(found) and all(one is not None and one.defined is not None for _, one in found)


def _headline(measured: list[tuple[EntryCell, Found]]) -> Iterator[str]:
    """The first column of each challenge that has numbers, row by row; of settings, how many are the paper's."""
    if measured and all(one.defined is not None for _, one in measured):
        same = sum(
            cell.theirs is not None and one.defined is not None and cell.theirs.says(one.defined)
            for cell, one in measured
        )
        yield f"{same} of {len(measured)} settings are the paper's"
        return
    for column in _first_columns(measured):
        mine = [(cell, one) for cell, one in measured if cell.column == column]
        many = len({cell.row.group for cell, _ in mine}) > 1
        rows = [f"{_name(cell, many)} {number_text(one)} ({paper_text(cell.theirs)})" for cell, one in mine]
        yield f"{column_head(column, many=column.challenge > 0)}: {'; '.join(rows)}"


def _first_columns(measured: list[tuple[EntryCell, Found]]) -> list[PublishedColumn]:
    """Of each challenge; a column of settings only where nothing is measured."""
    first: dict[int, PublishedColumn] = {}
    for cell, _ in sorted(measured, key=lambda pair: pair[1].defined is not None):
        first.setdefault(cell.column.challenge, cell.column)
    return list(first.values())


def _name(cell: EntryCell, with_group: bool) -> str:
    return f"{cell.row.group}: {cell.row.name}" if with_group else cell.row.name


def _counts(measured: list[tuple[EntryCell, Found]]) -> str:
    """Of the numbers that the row shows, with distinct episodes where some are copies."""
    shown = _first_columns(measured)
    found = [(one.estimate.n, one.distinct) for cell, one in measured if one.estimate and cell.column in shown]
    distinct = [different for n, different in found if different is not None and different < n]
    behind = f" ({_span(distinct)} distinct)" if distinct else ""
    return _span([n for n, _ in found]) + behind if found else "–"


def _span(counts: list[int]) -> str:
    low, high = min(counts), max(counts)
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def _differs(entry: PaperEntry, cells: list[EntryCell]) -> str:
    """The remark of the entry, and which rows are not made, with the reason."""
    empty: dict[str, list[str]] = {}
    for cell in cells:
        if isinstance(cell.ours, EmptyCell):
            names = empty.setdefault(cell.ours.reason, [])
            names += [] if cell.row.name in names else [cell.row.name]
    whole = all(isinstance(cell.ours, EmptyCell) for cell in cells)
    rows = [reason if whole else f"{', '.join(names)}: {reason}" for reason, names in empty.items()]
    parts = [entry.differs, entry.lacks, *rows, "" if cells or entry.differs else entry.otherwise]
    return "; ".join(part for part in parts if part) + (f" (`{entry.command}`)" if entry.command else "")


def _seconds(entry: PaperEntry, space: Workspace) -> float:
    """Processor time of everything that a label needs; labels share most of it."""
    times = space.times()
    steps = sum(times.get(step.about, 0.0) for step in paper_steps([entry], space) if not step.matches)
    matches = {match for cell in played_cells([entry]) for match in cell.matches(space)}
    return steps + sum(result.cpu_s for match in matches if (result := space.result(match)) is not None)


def _in_full(entries: list[PaperEntry], space: Workspace) -> dict[str, str]:
    """Every table with a number of ours, by label; a table that repeats another one is left out."""
    found: dict[str, str] = {}
    seen: set[object] = set()
    for entry in entries:
        here = _shown_in(entry, space)
        if any(cell.ours.found(here) for cell in entry.cells()):
            table = laid_out(entry, here)
            if table.rows not in seen:
                seen.add(table.rows)
                found[entry.label] = section(entry, table.heads, table.rows)
    return found
