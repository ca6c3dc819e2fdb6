import io
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest
from PIL import Image

from movingout.maps import load_map, map_names
from movingout.maps.render import map_png, map_svg
from movingout.maps.scene import DARK, LIGHT

SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("name", [*map_names(), "Simple"])
def test_every_map_is_a_png_of_the_side_asked_for(name: str) -> None:
    picture = Image.open(io.BytesIO(map_png(load_map(name), side=120)))
    assert (picture.format, picture.mode, picture.size) == ("PNG", "RGB", (120, 120))


@pytest.mark.parametrize("name", [*map_names(), "Simple"])
def test_every_map_is_well_formed_svg_with_all_its_parts(name: str) -> None:
    spec = load_map(name)
    root = ElementTree.fromstring(map_svg(spec))
    fills = [element.get("fill") for element in root.iter()]
    assert root.findtext(f"{SVG}title") == spec.title
    assert fills.count(LIGHT.goal) == len(spec.goals)
    assert fills.count(LIGHT.wall) == len(spec.walls)
    assert sum(fills.count(colour) for colour in (LIGHT.small, LIGHT.middle, LIGHT.large)) == len(spec.items)
    letters = [element.text for element in root.iter(f"{SVG}text")]
    assert letters[-2:] == ["B", "R"]
    assert letters.count("2") == sum(item.size == "large" for item in spec.items)


def test_the_dark_theme_has_its_own_colours() -> None:
    text = map_svg(load_map("HandOff"), DARK)
    assert DARK.surface in text
    assert DARK.wall in text
    assert LIGHT.wall not in text


def test_a_title_cannot_break_out_of_the_document() -> None:
    hostile = replace(load_map("HandOff"), title="<script>&", description='"</desc><script>')
    root = ElementTree.fromstring(map_svg(hostile))
    assert root.findtext(f"{SVG}title") == "<script>&"
    assert not list(root.iter(f"{SVG}script"))


def test_left_is_left_and_up_is_up() -> None:
    spec = load_map("PriorityPick")  # its goal is in the upper right corner
    picture = Image.open(io.BytesIO(map_png(spec, side=240)))
    assert picture.getpixel((225, 15)) != (255, 255, 255)
    assert picture.getpixel((5, 235)) == (255, 255, 255)


def test_a_notebook_shows_a_map() -> None:
    root = ElementTree.fromstring(load_map("HandOff")._repr_svg_())
    assert root.get("width") == root.get("height") == "360"
    assert root.findtext(f"{SVG}title") == "Hand Off"
