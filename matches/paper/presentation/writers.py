"""Laid-out tables as Markdown, LaTeX and HTML."""

from collections.abc import Callable
from html import escape

from movingout.matches.paper.presentation.latex_table import latex
from movingout.matches.paper.presentation.layout import LaidOutTable


def markdown(table: LaidOutTable) -> str:
    """A heading, the table and its notes."""
    rows = [table.heads, ("---", *("--:" for _ in table.heads[1:])), *table.rows]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(
        [f"## {table.title} (`{table.label}`)", "", *lines, "", *(f"- {note}" for note in table.notes), ""]
    )


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
