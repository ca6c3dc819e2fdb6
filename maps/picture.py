"""Paints the shapes of a scene with Pillow, smoothed by drawing larger and averaging down."""

import math
from collections.abc import Iterable
from functools import lru_cache

from PIL import Image, ImageDraw, ImageFont

from movingout.maps.scene import (
    LIGHT,
    Box,
    Disc,
    Label,
    Line,
    Point,
    Polygon,
    SceneState,
    Shape,
    Theme,
    backdrop,
    movers,
)
from movingout.maps.spec import ARENA_HALF, MapSpec

OVERSAMPLING = 3
SMALL_SIDE = 400  # below this many pixels the marks are drawn larger, to stay readable
SMALL_LABEL_SCALE = 1.5


def paint_scene(spec: MapSpec, state: SceneState, side: int, theme: Theme = LIGHT) -> Image.Image:
    """An RGB picture of `side` x `side` pixels; what never moves is painted once per map."""
    canvas = _painted_backdrop(spec, side, theme).copy()
    label_scale = SMALL_LABEL_SCALE if side < SMALL_SIDE else 1.0
    paint(canvas, movers(spec, state, theme, label_scale=label_scale))
    return canvas.reduce(OVERSAMPLING)


def paint(canvas: Image.Image, shapes: Iterable[Shape]) -> None:
    """Paint shapes, in arena units, over a square canvas that shows the whole arena."""
    brush = _Brush(canvas)
    for shape in shapes:
        match shape:
            case Box():
                brush.box(shape)
            case Polygon():
                brush.polygon(shape)
            case Disc():
                brush.disc(shape)
            case Line():
                brush.line(shape)
            case Label():
                brush.label(shape)


@lru_cache(maxsize=32)
def _painted_backdrop(spec: MapSpec, side: int, theme: Theme) -> Image.Image:
    canvas = Image.new("RGB", (side * OVERSAMPLING, side * OVERSAMPLING), theme.surface)
    paint(canvas, backdrop(spec, theme))
    return canvas


@lru_cache(maxsize=32)
def _font(pixels: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(pixels)


class _Brush:
    """A Pillow drawing in arena units, y up."""

    def __init__(self, canvas: Image.Image) -> None:
        self.draw = ImageDraw.Draw(canvas)
        self.unit = canvas.width / (2 * ARENA_HALF)  # pixels per arena unit

    def at(self, point: Point) -> Point:
        return (point[0] + ARENA_HALF) * self.unit, (ARENA_HALF - point[1]) * self.unit

    def pixels(self, width: float) -> int:
        return max(1, round(width * self.unit))

    def box(self, shape: Box) -> None:
        rect = shape.rect
        corners = [self.at((rect.left, rect.top)), self.at((rect.right, rect.bottom))]
        self.draw.rounded_rectangle(corners, shape.radius * self.unit, shape.fill)

    def polygon(self, shape: Polygon) -> None:
        points = [self.at(point) for point in shape.points]
        self.draw.polygon(points, shape.fill)
        if shape.stroke:
            self.draw.line([*points, points[0], points[1]], shape.stroke, self.pixels(shape.width), joint="curve")

    def disc(self, shape: Disc) -> None:
        (x, y), radius = self.at(shape.centre), (shape.radius + shape.width / 2) * self.unit
        self.draw.ellipse(
            (x - radius, y - radius, x + radius, y + radius),
            shape.fill or None,
            shape.stroke or None,
            self.pixels(shape.width) if shape.stroke else 0,
        )

    def line(self, shape: Line) -> None:
        points, width = [self.at(point) for point in shape.points], self.pixels(shape.width)
        self.draw.line(points, shape.colour, width, joint="curve")
        if shape.round:
            for x, y in (points[0], points[-1]):
                self.draw.ellipse((x - width / 2, y - width / 2, x + width / 2, y + width / 2), shape.colour)

    def label(self, shape: Label) -> None:
        pixels = math.ceil(shape.size * self.unit)
        text = shape.text.replace("–", "-")  # Pillow's built-in font has no dash but the hyphen
        stroke = max(1, pixels // 24)  # and one weight: an outline makes it bold
        self.draw.text(
            self.at(shape.centre),
            text,
            shape.colour,
            _font(pixels),
            "mm",
            stroke_width=stroke,
            stroke_fill=shape.colour,
        )
