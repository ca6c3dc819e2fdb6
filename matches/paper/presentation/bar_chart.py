"""A figure as bars: a panel per measure, in it for each row the paper's bar (outlined) and ours (filled), with errors.

Nothing is in colour alone, and colours follow the reader's light or dark theme.
"""

import math
from collections.abc import Iterator, Sequence
from html import escape

from movingout.matches.paper.cells import Found
from movingout.matches.paper.entry import EntryCell, PaperEntry
from movingout.matches.paper.presentation.layout import HEADINGS
from movingout.matches.paper.workspace import Workspace

GAP, TOP, HEIGHT, BAR, PITCH = 30, 60, 200, 18, 58
BASE = TOP + HEIGHT  # y of the axis
NUMBER = 12  # height of the number at the end of a bar
STYLE = (
    "text{font:12px system-ui,sans-serif;fill:#18212c}.ours{fill:#6b7c93}"
    ".theirs{fill:none;stroke:#6b7c93;stroke-width:1.5}.error{stroke:#18212c;stroke-width:1.5}.axis{stroke:#9aa5b3}"
    "@media(prefers-color-scheme:dark){text{fill:#e8ecf1}.ours{fill:#8b9bb0}.theirs{stroke:#8b9bb0}.error{stroke:#e8ecf1}}"
)


def bar_chart(entry: PaperEntry, space: Workspace) -> str:
    """An SVG; bars of what has not been measured yet are missing.

    Measures lie between 0 and 1, but for NFD, which is negative where items ended farther away; its bars hang down.
    """
    bars = [(cell, cell.ours.found(space)) for cell in entry.cells()]
    columns = list(dict.fromkeys(cell.column for cell, _ in bars))
    panel = 8 + PITCH * max(sum(cell.column == column for cell, _ in bars) for column in columns)
    below = _room_below(bars)
    parts = [
        part
        for number, column in enumerate(columns)
        for part in _panel(GAP + number * (panel + GAP), panel, [bar for bar in bars if bar[0].column == column], below)
    ]
    width = GAP + len(columns) * (panel + GAP)
    title = escape(f"{entry.heading} ({entry.label}): outlined the paper, filled here; lines: standard error")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {BASE + below + 40}" role="img">'
        f"<title>{title}</title><style>{STYLE}</style>"
        f'<text x="{GAP}" y="20">{title}</text>{"".join(parts)}</svg>\n'
    )


_Bars = Sequence[tuple[EntryCell, Found | None]]


def _room_below(bars: _Bars) -> int:
    """Height [px] of the lowest bar below the axis, with its error and number; 0 where none hangs down."""
    ours = [found.estimate for _, found in bars if found is not None and found.estimate is not None]
    ends = [one.mean - (one.stderr or 0.0) for one in ours if one.mean < 0.0]
    return math.ceil(_y(min(ends)) - BASE) + NUMBER if ends else 0


def _panel(left: float, width: float, bars: _Bars, below: int) -> Iterator[str]:
    yield f'<text x="{left}" y="{TOP - 14}">{escape(HEADINGS[bars[0][0].column.measure])}</text>'
    yield f'<line class="axis" x1="{left}" x2="{left + width}" y1="{BASE}" y2="{BASE}"/>'
    for number, (cell, found) in enumerate(bars):
        x = left + 8 + number * PITCH
        name = escape(cell.row.name)
        yield f'<text x="{x + BAR}" y="{BASE + below + 18}" text-anchor="middle">{name}</text>'
        if cell.theirs is not None:
            yield from _bar(x, "theirs", cell.theirs.mean, cell.theirs.stderr)
        if found is not None and found.estimate is not None:
            yield from _bar(x + BAR, "ours", found.estimate.mean, found.estimate.stderr)


def _bar(x: float, kind: str, mean: float, error: float | None) -> Iterator[str]:
    end = _y(mean)
    beside = end - 5 if mean >= 0.0 else end + NUMBER - 2
    yield f'<rect class="{kind}" x="{x}" y="{min(end, BASE):.1f}" width="{BAR}" height="{abs(BASE - end):.1f}"/>'
    yield f'<text x="{x + BAR / 2}" y="{beside:.1f}" text-anchor="middle" font-size="9">{mean:.2f}</text>'
    if error:
        middle, ends = x + BAR / 2, (_y(mean - error), _y(mean + error))
        yield f'<line class="error" x1="{middle}" x2="{middle}" y1="{ends[0]:.1f}" y2="{ends[1]:.1f}"/>'


def _y(value: float) -> float:
    return TOP + HEIGHT * (1.0 - value)
