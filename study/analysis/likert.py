"""How ratings are distributed, drawn as one bar per partner and item: shares of each value, neutral in the middle."""

from collections.abc import Sequence

from markupsafe import Markup, escape

from movingout.recordings.report.words import Words
from movingout.study.questionnaire import LIKERT_MAX, LIKERT_MIN

WIDTH, LABEL, BAR, GAP = 640.0, 150.0, 14.0, 5.0
VALUES = tuple(range(LIKERT_MIN, LIKERT_MAX + 1))


def likert_bars(rows: Sequence[tuple[str, Sequence[int]]], title: str, words: Words) -> Markup:
    """An SVG with one bar per row (partner, ratings 1 to 7); the neutral 4 is centred, so agreement leans right."""
    unit = (WIDTH - LABEL) / 2
    middle = LABEL + unit
    parts, y = [], 4.0
    for label, ratings in rows:
        shares = [ratings.count(value) / len(ratings) if ratings else 0.0 for value in VALUES]
        x = middle - unit * (sum(shares[:3]) + shares[3] / 2)
        parts.append(f'<text class="label" x="0" y="{y + 11:.1f}">{escape(label)}</text>')
        for value, share in zip(VALUES, shares, strict=True):
            said = words.say("study.ratings.bar", partner=label, value=value, share=f"{100 * share:.0f}")
            parts.append(
                f'<rect class="likert l{value}" x="{x:.1f}" y="{y:.1f}" width="{share * unit:.1f}" height="{BAR:g}">'
                f"<title>{escape(said)}</title></rect>"
            )
            x += share * unit
        y += BAR + GAP
    line = f'<line class="grid" x1="{middle:g}" x2="{middle:g}" y1="0" y2="{y:g}"/>'
    head = f'<svg class="bars" viewBox="0 0 {WIDTH:g} {y:g}" role="img" aria-label="{escape(title)}">'
    return Markup(f"{head}{''.join(parts)}{line}</svg>")
