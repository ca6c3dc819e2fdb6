"""Numbers that the page keeps, in today's words: the registry's, beside the paper's figures as they stand now."""

from collections.abc import Iterator, Sequence

from movingout.matches.paper.cells import DefinedCell, EmptyCell
from movingout.matches.paper.entry import EntryCell, PaperEntry
from movingout.matches.paper.page.page_labels import DRAWN, IN_PART, MEASURED, MISSING, PageLabel, cells_of, line
from movingout.matches.paper.presentation.layout import NO_VALUE, LaidOutTable, laid_out
from movingout.matches.paper.workspace import Workspace


def reworded(then: PageLabel, entry: PaperEntry, space: Workspace, differs: str) -> PageLabel:
    """A label that the page has, with our numbers as they are there and everything else as it would be written now.

    Unchanged where it cannot be made in this installation, which would say so instead of numbers.
    """
    if not entry.runnable:
        return then
    table = _table(then.table, entry, laid_out(entry, space), is_of_earlier(then, entry)) if then.table else ""
    return then.reworded(_status(then, entry, table), differs, table)


def is_of_earlier(then: PageLabel, entry: PaperEntry) -> bool:
    """Whether its numbers were measured otherwise than today, as `PaperEntry.earlier` says."""
    return entry.earlier is not None and then.day < entry.earlier.before


def section(entry: PaperEntry, heads: Sequence[str], rows: Sequence[Sequence[str]], is_older: bool = False) -> str:
    """A table in full, below its title; `is_older`: measured as `PaperEntry.earlier` says."""
    ruled = [heads, ["---", *("--:" for _ in heads[1:])], *rows]
    said = [*entry.notes, *([entry.earlier.said] if entry.earlier and is_older else [])]
    notes = ["", " ".join(said)] if said else []
    return "\n".join([f"### {entry.heading} (`{entry.label}`)", "", *map(line, ruled), *notes]) + "\n"


def _status(then: PageLabel, entry: PaperEntry, table: str) -> str:
    if entry.drawing:
        return DRAWN
    empty = any(isinstance(cell.ours, EmptyCell) and not cell.without_number for cell in entry.cells())
    missing = MISSING in table if table else then.status == IN_PART
    return IN_PART if entry.lacks or empty or missing else MEASURED


def _table(kept: str, entry: PaperEntry, today: LaidOutTable, is_older: bool) -> str:
    """Rows are known by their names, columns by their places; of a table with other columns, everything is kept."""
    lines = _with_code_ac([cells_of(one) for one in kept.splitlines() if one.startswith("| ")], today)
    if not lines or len(lines[0]) != len(today.heads):
        return kept
    found = {cells[0]: cells for cells in lines[2:]}
    cells, width = list(entry.cells()), len(today.columns)
    rows = [
        [row[0], *_numbers(row, found.get(row[0]), cells[number * width : (number + 1) * width])]
        for number, row in enumerate(today.rows)
    ]
    return section(entry, today.heads, rows, is_older)


def _with_code_ac(lines: list[list[str]], today: LaidOutTable) -> list[list[str]]:
    """With columns of AC of the code, of which a table of before has no value."""
    new = [1 + 2 * number for number, column in enumerate(today.columns) if column.measure == "official_ac"]
    if not lines or len(lines[0]) + 2 * len(new) != len(today.heads):
        return lines
    for place in new:
        lines = [
            [*one[:place], one[place - 2] if one[place - 2] in (MISSING, "–") else NO_VALUE, "", *one[place:]]
            for one in lines
        ]
    return lines


def _numbers(today: Sequence[str], kept: Sequence[str] | None, cells: Sequence[EntryCell]) -> Iterator[str]:
    """Ours and the paper's in turn, and n: ours of the page, never of the folder, which has another budget."""
    fixed = [isinstance(cell.ours, EmptyCell | DefinedCell) for cell in cells]
    for number, is_fixed in enumerate(fixed):
        place = 1 + 2 * number
        there = kept is not None and kept[place] != "–"
        yield today[place] if is_fixed else kept[place] if kept and there else MISSING
        yield today[place + 1]
    yield kept[-1] if kept else today[-1] if all(fixed) else "0"
