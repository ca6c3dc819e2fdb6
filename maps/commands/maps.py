"""`movingout maps`: list, show, check, render, randomize, generate and gallery."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from movingout.maps.commands import generated_maps, map_check
from movingout.maps.commands.parser import add_json, add_out
from movingout.maps.errors import MapError
from movingout.maps.files.output_file import write_output
from movingout.maps.files.terminal import printable, printable_lines
from movingout.maps.json_format import map_to_json
from movingout.maps.library import load_map, loadable_map_names
from movingout.maps.picture import paint_scene
from movingout.maps.randomize import SPLITS, randomize
from movingout.maps.render import PNG_SIDE, map_png, map_svg
from movingout.maps.scene import DARK, LIGHT, start_of
from movingout.maps.spec import SEAT_COLOURS, MapSpec, Rect

THEMES = {"light": LIGHT, "dark": DARK}
MAX_SIDE = 4096
_SKETCH_SIDE = 48  # characters across, two rows of pixels per line


def configure(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")

    listing = commands.add_parser(
        "list", help="the paper's twelve maps, the practice room and the tutorial", example="movingout maps list"
    )
    add_json(listing)
    listing.set_defaults(perform=_list)

    show = commands.add_parser(
        "show", help="one map on a page; --json gives its document", example="movingout maps show HandOff"
    )
    _add_map(show)
    add_json(show)
    show.set_defaults(perform=_show)

    check = commands.add_parser(
        "check",
        help="every error in maps and where it is; exit code 1 if there is one",
        example="movingout maps check mine.json",
    )
    map_check.configure(check)
    check.set_defaults(perform=map_check.perform)

    render = commands.add_parser(
        "render", help="a picture of a map's start, PNG or SVG", example="movingout maps render HandOff -o hand-off.svg"
    )
    _add_map(render)
    add_out(render, "FILE", "ends in .png or .svg; default: NAME.png")
    render.add_argument("--side", type=int, metavar="PIXELS", help=f"of a PNG; default: {PNG_SIDE}")
    render.add_argument("--theme", choices=THEMES, default="light", help="default: light")
    add_json(render)
    render.set_defaults(perform=_render)

    variant = commands.add_parser(
        "randomize",
        help="a Challenge 2 variant: other poses, masses, sizes and shapes",
        example="movingout maps randomize HandOff --seed 7 -o variant.json",
    )
    _add_map(variant)
    variant.add_argument("--seed", type=int, required=True, help="from 0; the same seed gives the same variant")
    variant.add_argument(
        "--split",
        choices=SPLITS,
        default="train",
        help="which (size, shape) pairs items have: train and evaluation "
        "share none, official has those that the map as designed lacks; default: train",
    )
    add_out(variant, "FILE", ".json, .png or .svg; default: JSON here")
    add_json(variant)
    variant.set_defaults(perform=_randomize)

    generated_maps.configure(commands)


def run(args: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)


def _add_map(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "map", metavar="NAME", help="a map's name, or the path of a map file; :mirror, :rot90, … after it"
    )


def _print_json(document: dict[str, Any]) -> None:
    print(json.dumps(document, indent=2))


# ---- list and show -----------------------------------------------------------------------------------------


def _list(args: argparse.Namespace) -> int:
    specs = [load_map(name) for name in loadable_map_names()]
    if args.json:
        _print_json({"maps": [_summary(spec) for spec in specs]})
        return 0
    console = Console(highlight=False)
    for spec in specs:
        number = str(spec.number or "–")
        console.print(f"{number:>2}  [bold]{spec.name:19}[/bold]  {spec.mode:18}  {_items_in_words(spec)}")
        console.print(Padding(f"[dim]{escape(spec.description)}[/dim]", (0, 0, 0, 4)))
    return 0


def _summary(spec: MapSpec) -> dict[str, Any]:
    return {
        "number": spec.number,
        "name": spec.name,
        "title": spec.title,
        "mode": spec.mode,
        "description": spec.description,
        "items": len(spec.items),
        "walls": len(spec.walls),
        "goals": len(spec.goals),
    }


def _items_in_words(spec: MapSpec) -> str:
    counts = {size: sum(item.size == size for item in spec.items) for size in ("small", "middle", "large")}
    return ", ".join(f"{count} {size}" for size, count in counts.items() if count)


def _show(args: argparse.Namespace) -> int:
    spec = load_map(args.map)
    if args.json:
        _print_json(map_to_json(spec))
        return 0
    console = Console(highlight=False)
    number = f"Map {spec.number}: " if spec.number else ""
    title, description = escape(printable(spec.title)), escape(printable_lines(spec.description))
    console.print(f"[bold]{number}{title}[/bold]  ({escape(spec.name)}, {spec.mode})")
    console.print(description)
    if console.is_terminal and console.color_system:
        console.print(_sketch(spec))
    table = Table(box=None, pad_edge=False)
    for column in ("", "shape", "size", "scale", "mass", "x", "y", "angle"):
        table.add_column(column, justify="left" if column in ("", "shape", "size") else "right")
    for colour, pose in zip(SEAT_COLOURS, spec.robots, strict=True):
        table.add_row(colour, "robot", "", "", "", *_numbers(pose.x, pose.y, pose.angle))
    for item in spec.items:
        numbers = _numbers(item.scale, item.mass, item.pose.x, item.pose.y, item.pose.angle)
        table.add_row(f"item {item.id}", item.shape, item.size, *numbers)
    console.print(table)
    for what, rects in (("goal", spec.goals), ("wall", spec.walls)):
        for rect in rects:
            console.print(f"{what}: {_in_words(rect)}")
    return 0


def _sketch(spec: MapSpec) -> Text:
    """The map in coloured half blocks, two pixels per character."""
    picture = paint_scene(spec, start_of(spec), _SKETCH_SIDE)
    rows = [[_hex(picture.getpixel((x, y))) for x in range(_SKETCH_SIDE)] for y in range(_SKETCH_SIDE)]
    sketch = Text()
    for upper, lower in zip(rows[::2], rows[1::2], strict=True):
        for top, bottom in zip(upper, lower, strict=True):
            sketch.append("▀", style=f"{top} on {bottom}")
        sketch.append("\n")
    return sketch


def _hex(pixel: Any) -> str:
    red, green, blue = pixel
    return f"#{red:02x}{green:02x}{blue:02x}"


def _numbers(*numbers: float) -> tuple[str, ...]:
    return tuple(f"{number:.3g}" for number in numbers)


def _in_words(rect: Rect) -> str:
    return f"x {rect.left:g} to {rect.right:g}, y {rect.bottom:g} to {rect.top:g}"


# ---- render, randomize -------------------------------------------------------------------------------------


def _render(args: argparse.Namespace) -> int:
    spec = load_map(args.map)
    side = PNG_SIDE if args.side is None else args.side
    if not 16 <= side <= MAX_SIDE:
        raise MapError(f"a picture has 16 to {MAX_SIDE} pixels on a side, not {side}")
    output = args.out or Path(f"{spec.file_name}.png")
    suffix = output.suffix.lower()
    if suffix not in (".png", ".svg"):
        raise MapError(f"cannot tell the format of {output}; let the name end in .png or .svg")
    if suffix == ".svg" and args.side is not None:
        raise MapError("--side is of a PNG; an SVG has no pixels")
    write_output(output, _file_content(spec, suffix, side, args.theme))
    if args.json:
        _print_json({"map": spec.name, "path": str(output), "format": suffix[1:]})
    else:
        print(f"wrote {output}")
    return 0


def _randomize(args: argparse.Namespace) -> int:
    variant = randomize(load_map(args.map), args.seed, args.split)
    if args.out is not None:
        suffix = args.out.suffix.lower()
        if suffix not in (".json", ".png", ".svg"):
            raise MapError(f"cannot tell the format of {args.out}; let the name end in .json, .png or .svg")
        write_output(args.out, _file_content(variant, suffix, PNG_SIDE, "light"))
    if args.json or args.out is None:
        _print_json(map_to_json(variant))
    else:
        print(f"wrote {args.out}: {variant.name}, {variant.variant}, {_items_in_words(variant)}")
    return 0


def _file_content(spec: MapSpec, suffix: str, side: int, theme: str) -> bytes:
    if suffix == ".json":
        return (json.dumps(map_to_json(spec), indent=2) + "\n").encode()
    if suffix == ".svg":
        return map_svg(spec, THEMES[theme]).encode()
    return map_png(spec, side, THEMES[theme])
