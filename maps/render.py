"""A map as a picture: SVG text or PNG bytes."""

import io
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path

from movingout.maps.picture import paint_scene
from movingout.maps.scene import LIGHT, Box, Disc, Label, Line, Point, Polygon, Shape, Theme, backdrop, movers, start_of
from movingout.maps.spec import ARENA_HALF, MapSpec

PNG_SIDE = 640
_SVG_SIDE = 960  # of the viewBox; 400 per arena unit
_UNIT = _SVG_SIDE / (2 * ARENA_HALF)


@dataclass(frozen=True, slots=True)
class SvgPicture:
    """An SVG document; notebooks show it."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: Path | str) -> None:
        """Write it as a file, replacing one of that name."""
        Path(path).write_text(self.svg, encoding="utf-8")


def map_png(spec: MapSpec, side: int = PNG_SIDE, theme: Theme = LIGHT) -> bytes:
    """The start of a map as a PNG file, `side` x `side` pixels."""
    file = io.BytesIO()
    paint_scene(spec, start_of(spec), side, theme).save(file, "PNG", optimize=True)
    return file.getvalue()


def map_svg(spec: MapSpec, theme: Theme = LIGHT, side: int | None = None) -> str:
    """The start of a map as an SVG document, with a title and a description for readers of the page.

    It scales with the page, or is `side` pixels wide.
    """
    size = f' width="{side}" height="{side}"' if side else ""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_SVG_SIDE} {_SVG_SIDE}"{size} role="img">',
        f"<title>{escape(spec.title)}</title>",
        f"<desc>{escape(spec.description)}</desc>",
        _elements([*backdrop(spec, theme), *movers(spec, start_of(spec), theme)]),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def arena_svg(shapes: Iterable[Shape], side: int) -> str:
    """Shapes in arena units as an SVG element of `side` pixels, to stand inside a larger document."""
    return f'<svg viewBox="0 0 {_SVG_SIDE} {_SVG_SIDE}" width="{side}" height="{side}">{_elements(shapes)}</svg>'


def _elements(shapes: Iterable[Shape]) -> str:
    return "\n".join(_element(shape) for shape in shapes)


def _element(shape: Shape) -> str:
    match shape:
        case Box(rect, radius, fill):
            x, y = _at((rect.left, rect.top))
            width, height = _length(rect.right - rect.left), _length(rect.top - rect.bottom)
            return f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{_length(radius)}" fill="{fill}"/>'
        case Polygon(points, fill, stroke, width_):
            edge = f' stroke="{stroke}" stroke-width="{_length(width_)}" stroke-linejoin="round"' if stroke else ""
            return f'<polygon points="{_points(points)}" fill="{fill}"{edge}/>'
        case Disc(centre, radius, fill, stroke, width_):
            x, y = _at(centre)
            edge = f' stroke="{stroke}" stroke-width="{_length(width_)}"' if stroke else ""
            return f'<circle cx="{x}" cy="{y}" r="{_length(radius)}" fill="{fill or "none"}"{edge}/>'
        case Line(points, colour, width_, round_):
            ends = ' stroke-linecap="round" stroke-linejoin="round"' if round_ else ""
            return (
                f'<polyline points="{_points(points)}" fill="none" stroke="{colour}" '
                f'stroke-width="{_length(width_)}"{ends}/>'
            )
        case Label(centre, text, size, colour):
            x, y = _at(centre)
            return (
                f'<text x="{x}" y="{y}" font-family="Inter, system-ui, sans-serif" font-weight="700" '
                f'font-size="{_length(size)}" text-anchor="middle" dominant-baseline="central" fill="{colour}">'
                f"{escape(text)}</text>"
            )


def _at(point: Point) -> tuple[str, str]:
    return _short((point[0] + ARENA_HALF) * _UNIT), _short((ARENA_HALF - point[1]) * _UNIT)


def _points(points: tuple[Point, ...]) -> str:
    return " ".join(",".join(_at(point)) for point in points)


def _length(length: float) -> str:
    return _short(length * _UNIT)


def _short(number: float) -> str:
    return f"{number:.1f}".rstrip("0").rstrip(".")
