"""Laid-out tables as Markdown, LaTeX and HTML."""

from collections.abc import Callable, Iterator, Sequence
from html import escape
from itertools import accumulate, groupby, pairwise

from movingout.matches.paper.layout import CellText, LaidOutTable, column_head


def markdown(table: LaidOutTable) -> str:
    """A heading, the table and its notes."""
    rows = [table.heads, ("---", *("--:" for _ in table.heads[1:])), *table.rows]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(
        [f"## {table.title} (`{table.label}`)", "", *lines, "", *(f"- {note}" for note in table.notes), ""]
    )


_SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "↑": r"$\uparrow$", "↓": r"$\downarrow$", "±": r"$\pm$",
    "–": "--", "×": r"$\times$",
}  # fmt: skip


def latex(table: LaidOutTable) -> str:
    """A table environment that needs booktabs and adjustbox; standard errors have columns of their own."""
    parts = [number for number, _ in enumerate(table.columns) for _ in range(2)]  # of ours and theirs, which column
    wide = [any(row[place].error for row in table.numbers) for place in range(len(parts))]
    rows = [
        " & ".join([_tex(row[0]), *_cells(numbers, wide), _tex(row[-1])]) + r" \\"
        for row, numbers in zip(table.rows, table.numbers, strict=True)
    ]
    width = sum(1 + has_error for has_error in wide)
    return "\n".join(
        [
            r"\begin{table}[h]", r"\centering", r"\begin{adjustbox}{width=\linewidth}",
            rf"\begin{{tabular}}{{l{'c' * (width + 1)}}}", r"\toprule",
            *_heads(table, wide), r"\midrule", *rows, r"\bottomrule", r"\end{tabular}",
            r"\end{adjustbox}", rf"\caption{{{_tex(table.title)}. {_tex(' '.join(table.notes))}}}",
            rf"\label{{{table.label}}}", r"\end{table}", "",
        ]
    )  # fmt: skip


def _cells(numbers: Sequence[CellText], wide: Sequence[bool]) -> Iterator[str]:
    """The best of a column in bold; its error beside it where the column has any."""
    for number, has_error in zip(numbers, wide, strict=True):
        value = _tex(number.value + number.behind)
        yield rf"\textbf{{{value}}}" if number.best else value
        if has_error:
            yield _tex(number.error)


def _heads(table: LaidOutTable, wide: Sequence[bool]) -> Iterator[str]:
    """A line of challenges where there are several, then one of measures, then whose numbers they are."""
    widths = [2 + wide[2 * k] + wide[2 * k + 1] for k in range(len(table.columns))]
    challenges = [column.challenge for column in table.columns]
    if len(set(challenges)) > 1:
        runs = [list(run) for _, run in groupby(range(len(challenges)), key=lambda k: challenges[k])]
        spans = [(f"Challenge {challenges[run[0]]}", sum(widths[k] for k in run)) for run in runs]
        yield from _spanning(spans)
    yield from _spanning(
        [(column_head(column, many=False), width) for column, width in zip(table.columns, widths, strict=True)]
    )
    names = [name for k, _ in enumerate(table.columns) for name in _sources(wide[2 * k], wide[2 * k + 1])]
    yield " & ".join(["", *names, "n"]) + r" \\"


def _spanning(spans: Sequence[tuple[str, int]]) -> Iterator[str]:
    """A line of heads over several columns each, and the rules below them."""
    heads = [rf"\multicolumn{{{width}}}{{c}}{{{_tex(text)}}}" for text, width in spans]
    yield " & ".join(["", *heads, ""]) + r" \\"
    ends = list(accumulate((width for _, width in spans), initial=1))
    yield " ".join(rf"\cmidrule(lr){{{first + 1}-{last}}}" for first, last in pairwise(ends))


def _sources(ours: bool, theirs: bool) -> list[str]:
    return ["here", *["StdErr"] * ours, "paper", *["StdErr"] * theirs]


def _tex(text: str) -> str:
    return "".join(_SPECIAL.get(letter, letter) for letter in text)


def html(table: LaidOutTable) -> str:
    """A page of its own."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.heads)
    rows = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>\n" for row in table.rows)
    notes = "".join(f"<li>{escape(note)}</li>\n" for note in table.notes)
    title = escape(f"{table.title} ({table.label})")
    style = (
        "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:75rem;padding:0 1rem}"
        "table{border-collapse:collapse;display:block;overflow-x:auto}"
        "th,td{border-bottom:1px solid #ccc;padding:.3rem .6rem;text-align:right;white-space:nowrap}"
        "th:first-child,td:first-child{text-align:left}"
    )
    return (
        f'<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<title>{title}</title>\n<style>{style}</style>\n'
        f"<h1>{title}</h1>\n<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n"
        f"<ul>\n{notes}</ul>\n</html>\n"
    )


WRITERS: dict[str, Callable[[LaidOutTable], str]] = {"md": markdown, "tex": latex, "html": html}
"""By the ending of the file."""
