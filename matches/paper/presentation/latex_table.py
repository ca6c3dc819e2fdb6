r"""A laid-out table as LaTeX, with the paper's layout (packages booktabs, adjustbox, multirow).

Groups of rows are as in the paper: a column of their own (\multirow), a line above them, or only a rule between them.
Over the measures stand the challenges or, where a measure has a column for each, the measures over the challenges.
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate, groupby, pairwise

from movingout.matches.paper.cells import PLAYED
from movingout.matches.paper.presentation.latex_text import tex
from movingout.matches.paper.presentation.layout import CellText, LaidOutTable, column_head
from movingout.matches.paper.published import PublishedColumn
from movingout.recordings.diversity.comparison import MEASURES as DIVERSITY

Span = tuple[str, int]
"""A head, and how many columns it stands over."""


def latex(table: LaidOutTable) -> str:
    """A table environment; standard errors have columns of their own."""
    parts = [number for number, _ in enumerate(table.columns) for _ in range(2)]  # of ours and theirs, which column
    wide = [any(row[place].error for row in table.numbers) for place in range(len(parts))]
    stub = 1 + (table.grouping == "column")
    columns = "l" * stub + "c" * (sum(1 + has_error for has_error in wide) + 1)
    return "\n".join(
        [
            r"\begin{table}[h]", r"\centering", r"\begin{adjustbox}{width=\linewidth}",
            rf"\begin{{tabular}}{{{columns}}}", r"\toprule",
            *_heads(table, wide, stub), r"\midrule", *_rows(table, wide, len(columns)), r"\bottomrule",
            r"\end{tabular}", r"\end{adjustbox}", rf"\caption{{{tex(table.title)}. {tex(' '.join(table.notes))}}}",
            rf"\label{{{table.label}}}", r"\end{table}", "",
        ]
    )  # fmt: skip


def _rows(table: LaidOutTable, wide: Sequence[bool], width: int) -> Iterator[str]:
    """Group after group, with a rule between two."""
    for number, (group, run) in enumerate(groupby(range(len(table.rows)), key=lambda k: table.names[k][0])):
        places = list(run)
        if number:
            yield r"\midrule"
        if group and table.grouping == "line":
            yield rf"\multicolumn{{{width}}}{{l}}{{\textit{{{tex(group)}}}}} \\"
            yield r"\midrule"
        for place in places:
            stub = [tex(table.names[place][1])]
            if table.grouping == "column":
                first = place == places[0]
                stub.insert(0, rf"\multirow{{{len(places)}}}{{*}}{{{tex(group)}}}" if first else "")
            yield " & ".join([*stub, *_cells(table.numbers[place], wide), tex(table.rows[place][-1])]) + r" \\"


def _cells(numbers: Sequence[CellText], wide: Sequence[bool]) -> Iterator[str]:
    """The best of a column in bold; its error beside it where the column has any."""
    for number, has_error in zip(numbers, wide, strict=True):
        value = tex(number.value + number.behind)
        yield rf"\textbf{{{value}}}" if number.best else value
        if has_error:
            yield tex(number.error)


def _heads(table: LaidOutTable, wide: Sequence[bool], stub: int) -> Iterator[str]:
    """Lines of spanning heads, then one of whose numbers they are."""
    widths = [2 + wide[2 * k] + wide[2 * k + 1] for k in range(len(table.columns))]
    for texts in _levels(table.columns):
        spans = [(text, [k for k, _ in run]) for text, run in groupby(enumerate(texts), key=lambda one: one[1])]
        yield from _spanning([(text, sum(widths[k] for k in places)) for text, places in spans], stub)
    names = [name for k, _ in enumerate(table.columns) for name in _sources(wide[2 * k], wide[2 * k + 1])]
    yield " & ".join([*_named(table.row_heads, stub), *names, "n"]) + r" \\"


def _levels(columns: Sequence[PublishedColumn]) -> list[list[str]]:
    """The lines of heads, from the top: a text per column, equal ones beside each other being one head."""
    measures = [column_head(column, many=False) for column in columns]
    challenges = [f"Challenge {column.challenge}" for column in columns]
    kinds = [_kind(column) for column in columns]
    if len(set(challenges)) > 1:
        by_measure = any(one == other for one, other in pairwise(measures))
        return [measures, challenges] if by_measure else [challenges, measures]
    return [kinds, measures] if {"Diversity", "Performance"} == set(kinds) else [measures]


def _kind(column: PublishedColumn) -> str:
    return "Diversity" if column.measure in DIVERSITY else "Performance" if column.measure in PLAYED else ""


def _spanning(spans: Sequence[Span], stub: int) -> Iterator[str]:
    """A line of heads over several columns each, and the rules below them."""
    heads = [rf"\multicolumn{{{width}}}{{c}}{{{tex(text)}}}" for text, width in spans]
    yield " & ".join([*[""] * stub, *heads, ""]) + r" \\"
    ends = list(accumulate((width for _, width in spans), initial=stub))
    yield " ".join(rf"\cmidrule(lr){{{first + 1}-{last}}}" for first, last in pairwise(ends))


def _named(heads: Sequence[str], stub: int) -> list[str]:
    """Those of the columns of names, as far as they have any."""
    named = [tex(head) for head in heads]
    return [*[""] * (stub - len(named)), *named][-stub:]


def _sources(ours: bool, theirs: bool) -> list[str]:
    return ["here", *["StdErr"] * ours, "paper", *["StdErr"] * theirs]
