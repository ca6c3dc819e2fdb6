"""Where the robots of each population were on a map: a picture with a panel per population (`fig:visual_task1`)."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from movingout.maps.picture import paint
from movingout.maps.scene import LIGHT, backdrop
from movingout.maps.spec import ARENA_HALF, MapSpec
from movingout.recordings.meshes import SEAT_RGB
from movingout.recordings.occupancy import heat_picture, smoothed, time_per_cell
from movingout.world.state import Floats

Style = Literal["dots", "trails", "heat"]
STYLES: tuple[Style, ...] = get_args(Style)
SIDE = 320  # pixels of a panel
CAPTION = 34
GAP = 12
COLUMNS = 5
DOT_EVERY = 2  # ticks
DOT = 1.5  # pixels
DOT_OPACITY = 90  # of 255
TRAIL_OPACITY = 60
LONGEST_NAME = 40  # characters


def position_plot(spec: MapSpec, groups: Mapping[str, Sequence[Floats]], style: Style) -> Image.Image:
    """A panel per population: blue and red places of all paths (T, 4) on the map."""
    columns = min(len(groups), COLUMNS)
    rows = -(-len(groups) // COLUMNS)
    width, height = columns * (SIDE + GAP) + GAP, rows * (SIDE + CAPTION + GAP) + GAP
    sheet = Image.new("RGB", (width, height), LIGHT.surface)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(15)
    floor = Image.new("RGB", (SIDE, SIDE), LIGHT.surface)
    paint(floor, backdrop(spec, LIGHT))
    for number, (name, paths) in enumerate(groups.items()):
        row, column = divmod(number, COLUMNS)
        x, y = GAP + column * (SIDE + GAP), GAP + row * (SIDE + CAPTION + GAP)
        panel = Image.alpha_composite(floor.convert("RGBA"), _STYLES[style](paths))
        sheet.paste(panel.convert("RGB"), (x, y + CAPTION))
        pen.text((x, y + 8), f"{_short(name)} (n = {len(paths)})", fill=LIGHT.ink, font=font)
    return sheet


def save_plots(
    groups: Mapping[str, Sequence[tuple[MapSpec, Sequence[Floats]]]], folder: Path, style: Style
) -> list[Path]:
    """A PNG per map in `folder`, named after it; populations without an episode on a map have no panel there."""
    specs = {spec.name: spec for maps in groups.values() for spec, _ in maps}
    written = []
    for name, spec in specs.items():
        there = {group: paths for group, maps in groups.items() for one, paths in maps if one.name == name and paths}
        path = folder / f"positions-{spec.file_name}.png"
        position_plot(spec, there, style).save(path, "PNG", optimize=True)
        written.append(path)
    return written


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"…{name[1 - LONGEST_NAME :]}"


def _pixels(places: Floats) -> list[tuple[float, float]]:
    unit = SIDE / (2 * ARENA_HALF)
    return [((x + ARENA_HALF) * unit, (ARENA_HALF - y) * unit) for x, y in places.tolist()]


def _colour(seat: int, opacity: int) -> tuple[int, int, int, int]:
    red, green, blue = (round(255 * part) for part in SEAT_RGB[seat])
    return red, green, blue, opacity


def _dots(paths: Sequence[Floats]) -> Image.Image:
    """A dot per place, blue and red in turn, so that neither hides the other."""
    layer = Image.new("RGBA", (SIDE, SIDE), (255, 255, 255, 0))
    for path in paths:
        for seat in (0, 1):
            one = Image.new("RGBA", (SIDE, SIDE), (255, 255, 255, 0))
            pen = ImageDraw.Draw(one)
            for x, y in _pixels(path[::DOT_EVERY, 2 * seat : 2 * seat + 2]):
                pen.ellipse((x - DOT, y - DOT, x + DOT, y + DOT), fill=_colour(seat, DOT_OPACITY))
            layer = Image.alpha_composite(layer, one)
    return layer


def _trails(paths: Sequence[Floats]) -> Image.Image:
    layer = Image.new("RGBA", (SIDE, SIDE), (255, 255, 255, 0))
    for path in paths:
        for seat in (0, 1):
            one = Image.new("RGBA", (SIDE, SIDE), (255, 255, 255, 0))
            ImageDraw.Draw(one).line(_pixels(path[:, 2 * seat : 2 * seat + 2]), _colour(seat, TRAIL_OPACITY), 2)
            layer = Image.alpha_composite(layer, one)
    return layer


def _heat(paths: Sequence[Floats]) -> Image.Image:
    grids = [sum((time_per_cell(path[1:, 2 * seat : 2 * seat + 2]) for path in paths), np.zeros(1)) for seat in (0, 1)]
    picture = heat_picture([smoothed(grid) for grid in grids], (0, 1), pixels=1)
    return Image.fromarray(picture, "RGBA").resize((SIDE, SIDE), Image.Resampling.BILINEAR)


_STYLES: dict[Style, Callable[[Sequence[Floats]], Image.Image]] = {"dots": _dots, "trails": _trails, "heat": _heat}
