"""`movingout maps generate` and `movingout maps gallery`: maps made from a seed, and a sheet of maps to look at."""

import argparse
import base64
import html
import json
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_out
from movingout.maps.errors import MapError
from movingout.maps.files.output_file import write_output
from movingout.maps.generated.generator import generate
from movingout.maps.generated.names import DIFFICULTIES, MODE_WORDS, is_generated
from movingout.maps.generated.proved import ticks_needed
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.maps.library import is_reserved, load_map
from movingout.maps.render import map_png
from movingout.maps.selection import HELP, selected_maps
from movingout.maps.spec import MapSpec
from movingout.maps.symmetry import split_name

_MOST = 500  # pictures on a sheet
_SIDE = 280  # pixels of a picture
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Maps</title><style>
:root {{ color-scheme: light dark; font: 14px/1.4 system-ui, sans-serif }}
body {{ margin: 1.5rem }}
main {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: 1.25rem }}
figure {{ margin: 0 }}
img {{ width: 100%; border: 1px solid #8886; border-radius: 6px }}
figcaption {{ overflow-wrap: anywhere }}
small {{ opacity: .75 }}
</style></head><body><h1>{title}</h1><main>
{figures}
</main></body></html>
"""


def configure(commands: Any) -> None:
    """Add both to the commands of `movingout maps`."""
    one = commands.add_parser(
        "generate",
        help="the map of a seed: walls, goals and items drawn for one of the paper's modes",
        example="movingout maps generate --mode awareness --seed 12 -o mine.json",
    )
    one.add_argument("--mode", choices=MODE_WORDS.values(), required=True, help="what the map demands of the two")
    one.add_argument("--seed", type=int, required=True, help="from 0; the same seed gives the same map everywhere")
    one.add_argument("--difficulty", choices=DIFFICULTIES, help="default: easy, medium and hard by turns of the seed")
    one.add_argument("--name", default="", help="name of the map in the document; default: that of the seed")
    add_out(one, "FILE", ".json or .png; default: JSON here")
    one.add_argument("--json", action="store_true", help="one JSON document on standard output")
    one.set_defaults(perform=_generate)

    sheet = commands.add_parser(
        "gallery",
        help="a page with pictures of many maps",
        example="movingout maps gallery generated:test:60 -o gallery.html",
    )
    sheet.add_argument(
        "map", metavar="MAPS", nargs="?", default="generated:test:60", help=f"{HELP}; default: %(default)s"
    )
    add_out(sheet, "FILE", "a page, .html; default: gallery.html", default=Path("gallery.html"))
    sheet.add_argument("--json", action="store_true", help="one JSON document on standard output")
    sheet.set_defaults(perform=_gallery)


def _generate(args: argparse.Namespace) -> int:
    mode = next(mode for mode, word in MODE_WORDS.items() if word == args.mode)
    spec = generate(args.seed, mode, args.difficulty)
    document = map_to_json(spec) | ({"name": args.name} if args.name else {})
    _check_name(args.name, document)
    if args.out is None or args.json:
        print(json.dumps(document, indent=2))
    if args.out is not None:
        suffix = args.out.suffix.lower()
        if suffix not in (".json", ".png"):
            raise MapError(f"cannot tell the format of {args.out}; let the name end in .json or .png")
        content = map_png(spec) if suffix == ".png" else (json.dumps(document, indent=2) + "\n").encode()
        write_output(args.out, content)
        if not args.json:
            print(f"wrote {args.out}: {spec.name}, {proof_in_words(spec.name)}")
    return 0


def _check_name(name: str, document: dict[str, object]) -> None:
    """Raises MapError for a name that no map of one's own can have."""
    if not name:
        return
    if is_reserved(name):
        raise MapError(f"--name: {name} is the name of a shipped map; choose another")
    try:
        map_from_json(document)
    except MapError as error:
        raise MapError(f"--{error}") from None


def _gallery(args: argparse.Namespace) -> int:
    if args.out.suffix.lower() not in (".html", ".htm"):
        raise MapError(f"a gallery is a page; let the name of {args.out} end in .html")
    names = selected_maps(args.map)
    if len(names) > _MOST:
        raise MapError(f"a gallery has up to {_MOST} maps, not {len(names)}; name fewer, as in generated:test:60")
    figures = "\n".join(_figure(load_map(name)) for name in names)
    page = _PAGE.format(title=f"{len(names)} maps: {html.escape(args.map)}", figures=figures)
    write_output(args.out, page.encode())
    if args.json:
        print(json.dumps({"maps": names, "path": str(args.out)}))
    else:
        print(f"wrote {args.out}: {len(names)} maps")
    return 0


def _figure(spec: MapSpec) -> str:
    picture = base64.b64encode(map_png(spec, _SIDE)).decode()
    name, about = html.escape(spec.name), html.escape(f"{spec.mode}, {len(spec.items)} items")
    if is_generated(spec.name):
        about += f"<br>{proof_in_words(spec.name)}"
    image = f'<img alt="{name}" loading="lazy" src="data:image/png;base64,{picture}">'
    return f"<figure>{image}<figcaption>{name}<br><small>{about}</small></figcaption></figure>"


def proof_in_words(name: str) -> str:
    """What is known about playing a generated map to the end; nothing of a file's map whose name only begins so."""
    try:
        ticks = ticks_needed(split_name(name)[0])
    except MapError:
        ticks = None
    return "not on the list of maps that a scripted pair solves" if ticks is None else f"solved in {ticks} ticks"
