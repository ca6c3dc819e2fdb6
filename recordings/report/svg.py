"""The figures of a report, as inline SVG coloured by custom properties of the page. Knows shapes, not statistics."""

import base64
import io
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup, escape
from PIL import Image

from movingout.maps.shapes import outline
from movingout.maps.spec import ARENA_HALF, SEAT_COLOURS, ItemSpec, MapSpec, Rect
from movingout.recordings.occupancy import heat_picture, smoothed
from movingout.world.state import Floats

SIDE = 240  # of an arena picture
_UNIT = SIDE / (2 * ARENA_HALF)
_PLOT = (240, 64)  # of a curve: width, height
_LEFT = 36  # room for the scale


class Dot(NamedTuple):
    """A mean with its interval on a scale; `mark` selects the shape."""

    mark: int  # the population's place
    mean: float
    half: float  # of the interval, 0 for none
    title: str


class Segment(NamedTuple):
    """A stretch on a strip, linked."""

    seat: int
    start: float  # in [0, 1] of the strip
    end: float
    href: str
    title: str


def arena(spec: MapSpec, presence: Floats, title: str, *, items: bool) -> Markup:
    """A map with a heat map of where blue and red spent their time, (2, cells, cells) seconds."""
    shapes = [
        f'<rect class="floor" width="{SIDE}" height="{SIDE}"/>',
        *(f'<rect class="goal" {_box(goal)}/>' for goal in spec.goals),
        *(_item(item) for item in spec.items if items),
        f'<image href="{_heat(presence)}" width="{SIDE}" height="{SIDE}"/>',
        *(f'<rect class="wall" {_box(wall)}/>' for wall in spec.walls),
    ]
    return _svg(SIDE, SIDE, title, "".join(shapes), "arena")


def dots(
    rows: Sequence[tuple[str, Sequence[Dot]]],
    low: float,
    high: float,
    title: str,
    decimal: Callable[[str], str] = str,
) -> Markup:
    """One row per label, with dots and intervals on a common scale from `low` to `high`; the mark of a dot is also its
    line within the row. `decimal` writes the numbers of the scale as a language does."""
    left, width, pitch = 150, 430, 12
    scale = (width - left - 16) / ((high - low) or 1.0)
    parts, y = [], 22.0
    for value in _ticks(low, high):
        x = left + (value - low) * scale
        parts.append(f'<text class="scale" x="{x:.1f}" y="12" text-anchor="middle">{decimal(f"{value:g}")}</text>')
        parts.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="18" y2="{{bottom}}"/>')
    height = 6 + pitch * (1 + max((dot.mark for _, row in rows for dot in row), default=0))
    for label, row in rows:
        parts.append(f'<text class="label" x="0" y="{y + height / 2 + 4:.1f}">{escape(label)}</text>')
        parts += [_dot(dot, left, low, scale, y + 9 + dot.mark * pitch) for dot in row]
        y += height
    return _svg(width, y + 4, title, "".join(parts).replace("{bottom}", f"{y:.0f}"), "dots")


def mark(kind: int, x: float, y: float) -> str:
    """The shape that stands for a population: disc, square, triangle, diamond, and the same hollow."""
    hollow = " hollow" if kind // 4 % 2 else ""
    shape = (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" class="mark{hollow}"/>',
        f'<rect x="{x - 3.5:.1f}" y="{y - 3.5:.1f}" width="7" height="7" class="mark{hollow}"/>',
        f'<path d="M{x:.1f} {y - 4.5:.1f}l4.5 8h-9z" class="mark{hollow}"/>',
        f'<path d="M{x:.1f} {y - 5:.1f}l5 5l-5 5l-5 -5z" class="mark{hollow}"/>',
    )
    return shape[kind % 4]


def legend_mark(kind: int) -> Markup:
    return Markup(f'<svg class="key" width="12" height="12" aria-hidden="true">{mark(kind, 6, 6)}</svg>')


def curves(series: Sequence[tuple[str, Floats]], title: str) -> Markup:
    """Curves of values in [0, 1] over the seconds; a series is its CSS class and its values, NaN for a gap."""
    width, height = _PLOT
    count = max((len(values) for _, values in series), default=0)
    step = (width - _LEFT) / max(count, 1)
    parts = [
        f'<line class="grid" x1="{_LEFT}" x2="{width}" y1="{y}" y2="{y}"/>'
        f'<text class="scale" x="{_LEFT - 4}" y="{y + 4}" text-anchor="end">{words}</text>'
        for y, words in ((6, "100 %"), (height - 16, "0"))
    ]
    parts += [
        f'<text class="scale" x="{_LEFT + second * step:.1f}" y="{height - 2}" '
        f'text-anchor="{"start" if second == 0 else "middle"}">{second} s</text>'
        for second in range(0, count, 10 if count <= 60 else 60)
    ]
    for name, values in series:
        points = [
            (_LEFT + (second + 0.5) * step, height - 16 - float(value) * (height - 22))
            for second, value in enumerate(values)
        ]
        parts.append(f'<path class="curve {name}" d="{_path(points)}"/>')
    return _svg(width, height, title, "".join(parts), "curves")


def strip(segments: Sequence[Segment], length: float, title: str, letters: tuple[str, str]) -> Markup:
    """Stretches of time, blue above red; `length` is the share of the width that the episode lasted."""
    width, height = _PLOT[0], 18
    span = (width - _LEFT) * length
    parts = [f'<rect class="lane" x="{_LEFT}" y="{1 + 9 * seat}" width="{span:.1f}" height="7"/>' for seat in (0, 1)]
    for segment in segments:
        x, wide = _LEFT + segment.start * span, max((segment.end - segment.start) * span, 1.5)
        parts.append(
            f'<a href="{escape(segment.href)}"><rect class="{SEAT_COLOURS[segment.seat]}" x="{x:.1f}" '
            f'width="{wide:.1f}" y="{1 + 9 * segment.seat}" height="7">'
            f"<title>{escape(segment.title)}</title></rect></a>"
        )
    names = "".join(
        f'<text class="scale" x="{_LEFT - 4}" y="{8 + 9 * seat}" text-anchor="end">{escape(letter)}</text>'
        for seat, letter in enumerate(letters)
    )
    return _svg(width, height, title, names + "".join(parts), "strip", role="group")


def _svg(width: float, height: float, title: str, content: str, kind: str, role: str = "img") -> Markup:
    head = f'<svg class="{kind}" viewBox="0 0 {width:g} {height:g}" role="{role}" aria-label="{escape(title)}">'
    return Markup(f"{head}{content}</svg>")


def _dot(dot: Dot, left: float, low: float, scale: float, y: float) -> str:
    x = left + (dot.mean - low) * scale
    reach = dot.half * scale
    return (
        f"<g><title>{escape(dot.title)}</title>"
        f'<line class="whisker" x1="{x - reach:.1f}" x2="{x + reach:.1f}" y1="{y:.1f}" y2="{y:.1f}"/>'
        f"{mark(dot.mark, x, y)}</g>"
    )


def _ticks(low: float, high: float) -> list[float]:
    """About five round numbers from `low` to `high`."""
    raw = (high - low) / 4
    size = 10.0 ** np.floor(np.log10(raw))
    step = next(size * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if size * factor >= raw * 0.999)
    first = np.ceil(low / step - 1e-9)
    return [float(k * step) + 0.0 for k in np.arange(first, np.floor(high / step + 1e-9) + 1)]


def _path(points: Sequence[tuple[float, float]]) -> str:
    words, pen = [], "M"
    for x, y in points:
        if np.isnan(y):
            pen = "M"
        else:
            words.append(f"{pen}{x:.1f} {y:.1f}" + (f"L{x:.1f} {y:.1f}" if pen == "M" else ""))
            pen = "L"
    return "".join(words)


def _heat(presence: Floats) -> str:
    """The heat map as a data URL, a pixel per cell; the browser smooths it."""
    grids = (smoothed(presence[0]), smoothed(presence[1]))
    picture = heat_picture(grids, (0, 1), pixels=1)
    file = io.BytesIO()
    Image.fromarray(picture, "RGBA").save(file, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def _item(item: ItemSpec) -> str:
    pose = item.pose
    x, y = (pose.x + ARENA_HALF) * _UNIT, (ARENA_HALF - pose.y) * _UNIT
    if item.shape == "circle":
        return f'<circle class="item" cx="{x:.1f}" cy="{y:.1f}" r="{item.scale * _UNIT:.1f}"/>'
    points = " ".join(f"{px * _UNIT:.1f},{-py * _UNIT:.1f}" for px, py in outline(item.shape, item.scale))
    turn = -np.degrees(pose.angle)
    return f'<polygon class="item" points="{points}" transform="translate({x:.1f} {y:.1f}) rotate({turn:.1f})"/>'


def _box(rect: Rect) -> str:
    x, y = (rect.left + ARENA_HALF) * _UNIT, (ARENA_HALF - rect.top) * _UNIT
    return (
        f'x="{x:.1f}" y="{y:.1f}" width="{(rect.right - rect.left) * _UNIT:.1f}" '
        f'height="{(rect.top - rect.bottom) * _UNIT:.1f}"'
    )
