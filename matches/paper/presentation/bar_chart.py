"""A figure as bars: a panel per measure, in it for each row the paper's bar (outlined) and ours (filled), with errors.

Nothing is in colour alone, and colours follow the reader's light or dark theme.
"""

from collections.abc import Iterator
from html import escape

from movingout.matches.paper.entry import EntryCell, PaperEntry
from movingout.matches.paper.presentation.layout import HEADINGS
from movingout.matches.paper.workspace import Workspace

GAP, TOP, HEIGHT, BAR, PITCH = 30, 60, 200, 18, 58
STYLE = (
    "text{font:12px system-ui,sans-serif;fill:#18212c}.ours{fill:#6b7c93}"
    ".theirs{fill:none;stroke:#6b7c93;stroke-width:1.5}.error{stroke:#18212c;stroke-width:1.5}.axis{stroke:#9aa5b3}"
    "@media(prefers-color-scheme:dark){text{fill:#e8ecf1}.ours{fill:#8b9bb0}.theirs{stroke:#8b9bb0}.error{stroke:#e8ecf1}}"
)


def bar_chart(entry: PaperEntry, space: Workspace) -> str:
    """An SVG; bars of what has not been measured yet are missing. All measures lie between 0 and 1."""
    cells = list(entry.cells())
    columns = list(dict.fromkeys(cell.column for cell in cells))
    panel = 8 + PITCH * max(sum(cell.column == column for cell in cells) for column in columns)
    parts = [
        part
        for number, column in enumerate(columns)
        for part in _panel(GAP + number * (panel + GAP), panel, [c for c in cells if c.column == column], space)
    ]
    width = GAP + len(columns) * (panel + GAP)
    title = escape(f"{entry.heading} ({entry.label}): outlined the paper, filled here; lines: standard error")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {TOP + HEIGHT + 40}" role="img">'
        f"<title>{title}</title><style>{STYLE}</style>"
        f'<text x="{GAP}" y="20">{title}</text>{"".join(parts)}</svg>\n'
    )


def _panel(left: float, width: float, cells: list[EntryCell], space: Workspace) -> Iterator[str]:
    yield f'<text x="{left}" y="{TOP - 14}">{escape(HEADINGS[cells[0].column.measure])}</text>'
    yield f'<line class="axis" x1="{left}" x2="{left + width}" y1="{TOP + HEIGHT}" y2="{TOP + HEIGHT}"/>'
    for number, cell in enumerate(cells):
        x = left + 8 + number * PITCH
        name = escape(cell.row.name)
        yield f'<text x="{x + BAR}" y="{TOP + HEIGHT + 18}" text-anchor="middle">{name}</text>'
        found = cell.ours.found(space)
        if cell.theirs is not None:
            yield from _bar(x, "theirs", cell.theirs.mean, cell.theirs.stderr)
        if found is not None and found.estimate is not None:
            yield from _bar(x + BAR, "ours", found.estimate.mean, found.estimate.stderr)


def _bar(x: float, kind: str, mean: float, error: float | None) -> Iterator[str]:
    yield f'<rect class="{kind}" x="{x}" y="{_y(mean):.1f}" width="{BAR}" height="{TOP + HEIGHT - _y(mean):.1f}"/>'
    yield f'<text x="{x + BAR / 2}" y="{_y(mean) - 5:.1f}" text-anchor="middle" font-size="9">{mean:.2f}</text>'
    if error:
        middle, ends = x + BAR / 2, (_y(mean - error), _y(mean + error))
        yield f'<line class="error" x1="{middle}" x2="{middle}" y1="{ends[0]:.1f}" y2="{ends[1]:.1f}"/>'


def _y(value: float) -> float:
    return TOP + HEIGHT * (1.0 - value)
