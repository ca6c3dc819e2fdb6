"""Our map JSON: both directions, the schema beside it, and the sentence for every fault."""

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from movingout import maps
from movingout.maps import MapError, load_map, map_from_json, map_names, map_to_json
from movingout.maps.errors import MapDocumentError

SCHEMA = json.loads((Path(str(maps.__file__)).parent / "map.schema.json").read_text())
ALL_MAPS = (*map_names(), "Simple")


def changed(path: str, value: object) -> dict[str, Any]:
    """The CornerDecision document with one value replaced, or removed when the value is Ellipsis."""
    document = copy.deepcopy(map_to_json(load_map("CornerDecision")))
    *parents, last = [int(key) if key.isdigit() else key for key in path.split("/")]
    target: Any = document
    for key in parents:
        target = target[key]
    if value is ...:
        del target[last]
    else:
        target[last] = value
    return document


@pytest.mark.parametrize("name", ALL_MAPS)
def test_a_map_survives_the_way_to_json_and_back(name: str) -> None:
    spec = load_map(name)
    assert map_from_json(json.loads(json.dumps(map_to_json(spec)))) == spec


@pytest.mark.parametrize("name", ALL_MAPS)
def test_shipped_maps_obey_the_schema(name: str) -> None:
    jsonschema.validate(map_to_json(load_map(name)), SCHEMA)


def test_a_variant_is_kept() -> None:
    spec = map_from_json(changed("variant", "challenge 2, seed 7"))
    assert spec.variant == "challenge 2, seed 7"
    assert map_from_json(map_to_json(spec)) == spec


FAULTS = [
    ("format", 2, "format: format 2 is unknown; this program reads format 1"),
    ("name", "a map", "name: 1 to 40 letters"),
    ("title", 5, "title: a text of at most 500 characters"),
    ("number", -1, "number: a whole number from 0"),
    ("number", True, "number: a whole number from 0"),
    ("mode", "fun", "mode: 'fun' is unknown; known: coordination, awareness, action consistency, practice"),
    ("units", {"angle": "degrees"}, "units: other units are not supported"),
    ("colour", "red", "the map: unknown key 'colour'; known: format, name"),
    ("robots", [], "robots: an object is needed here"),
    ("robots/red", ..., "robots: 'red' is missing"),
    ("robots/blue/x", "left", "robots.blue.x: a number is needed here, not 'left'"),
    ("robots/blue/angle", float("nan"), "robots.blue.angle: a number is needed here, not nan"),
    ("walls", None, "walls: a list is needed here"),
    ("walls/1/y0", 3, "walls[1].y0: 3 is outside -1.2 to 1.2"),
    ("walls/0/x1", -0.2, "walls[0]: the rectangle has no area"),
    ("goals", [], "goals: 1 to 64 entries are allowed, not 0"),
    ("items/2/shape", "hexagram", "items[2].shape: 'hexagram' is unknown; known: triangle, square"),
    ("items/2/scale", 0, "items[2].scale: 0 is outside 0.01 to 1.2"),
    ("items/2/mass", ..., "items[2]: 'mass' is missing"),
    ("items/2/id", 0, "items: two items have the same id"),
]


@pytest.mark.parametrize(("path", "value", "message"), FAULTS)
def test_a_fault_is_named_with_its_path(path: str, value: object, message: str) -> None:
    with pytest.raises(MapError) as caught:
        map_from_json(changed(path, value))
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("key", ["title", "description", "variant"])
def test_a_text_with_half_a_character_is_refused_because_no_page_could_be_sent_it(key: str) -> None:
    with pytest.raises(MapError, match=f"{key}: half of a character stands in this text"):
        map_from_json(changed(key, json.loads('"cut: \\ud83d"')))
    assert getattr(map_from_json(changed(key, "whole: 😀")), key) == "whole: 😀"


def test_a_fault_has_a_code_and_values_for_pages_in_other_languages() -> None:
    with pytest.raises(MapDocumentError) as caught:
        map_from_json(changed("items/2/mass", "heavy"))
    fault = caught.value
    assert (fault.path, fault.code, fault.values) == ("items[2].mass", "no_number", {"value": '"heavy"'})
    assert str(pickle.loads(pickle.dumps(fault))) == str(fault), "also out of a worker process"


BEYOND_SCHEMA = ("a number is needed here, not nan", "the rectangle has no area", "two items have the same id")


@pytest.mark.parametrize(
    ("path", "value"),
    [(path, value) for path, value, message in FAULTS if not message.endswith(BEYOND_SCHEMA)],
)
def test_the_schema_refuses_what_the_program_refuses(path: str, value: object) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(changed(path, value), SCHEMA)


@pytest.mark.parametrize("document", [None, [], "HandOff", 3])
def test_what_is_no_object_is_refused(document: object) -> None:
    with pytest.raises(MapError, match="the map: an object is needed here"):
        map_from_json(document)
