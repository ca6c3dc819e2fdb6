"""Maps as JSON, in both directions. Reading is strict: every fault is reported with its JSON path.

`map.schema.json` beside this file says the same to editors and other programs.
"""

import json
import math
import re
from collections.abc import Callable
from typing import Any, TypeVar

from movingout.maps.errors import DocumentFault, MapDocumentError, MapError
from movingout.maps.spec import ARENA_HALF, MODES, SHAPES, SIZES, ItemSpec, MapSpec, Pose, Rect

FORMAT = 1
UNITS = {
    "length": "arena units: the arena is the square from -1.2 to 1.2 in x and y, y up",
    "angle": "radians, 0 looks along +y, counter-clockwise",
    "mass": "engine units, a robot has 1",
}
NAME_PATTERN = (
    r"^(generated:(coordination|awareness|consistency):(0|[1-9]\d{0,5})(:(easy|medium|hard))?|"
    r"[A-Za-z][A-Za-z0-9_-]{0,39})"
    r"(:mirror)?(:rot(90|180|270))?$"
)
MAX_ITEMS = 7  # the observation has seven item slots
MAX_RECTS = 64
LONGEST_TEXT = 500
SCALES = (0.01, ARENA_HALF)  # [arena units] least and largest
MASSES = (0.001, 1000.0)
_LONGEST_QUOTE = 60

_POSE = ("x", "y", "angle")
_RECT = ("x0", "y0", "x1", "y1")
_ITEM = ("id", "shape", "size", "scale", "mass", *_POSE)
_MAP = ("format", "name", "title", "number", "mode", "description", "robots", "walls", "goals", "items")
_MAP_OPTIONAL = ("units", "variant")

_T = TypeVar("_T")


def map_to_json(spec: MapSpec) -> dict[str, Any]:
    """The JSON document of a map; `map_from_json` gives back an equal map."""
    blue, red = (_pose_to_json(pose) for pose in spec.robots)
    document: dict[str, Any] = {
        "format": FORMAT,
        "name": spec.name,
        "title": spec.title,
        "number": spec.number,
        "mode": spec.mode,
        "description": spec.description,
        "units": dict(UNITS),
        "robots": {"blue": blue, "red": red},
        "walls": [_rect_to_json(rect) for rect in spec.walls],
        "goals": [_rect_to_json(rect) for rect in spec.goals],
        "items": [_item_to_json(item) for item in spec.items],
    }
    if spec.variant:
        document["variant"] = spec.variant
    return document


def map_from_json(document: object) -> MapSpec:
    """The map of a JSON document; MapDocumentError names the first fault and where it is."""
    fields = _object(document, "", _MAP, _MAP_OPTIONAL)
    if fields["format"] != FORMAT:
        what = f"format {_quoted(fields['format'])} is unknown; this program reads format {FORMAT}"
        raise _fault("format", what, "format", value=_json(fields["format"]), known=FORMAT)
    if fields.get("units", UNITS) != UNITS:
        raise _fault("units", f"other units are not supported; leave it out or write {UNITS}", "units")
    robots = _object(fields["robots"], "robots", ("blue", "red"))
    items = _list(fields["items"], "items", _item, 1, MAX_ITEMS)
    if len({item.id for item in items}) < len(items):
        raise _fault("items", "two items have the same id; give each its own", "same_id")
    if not isinstance(fields["name"], str) or not re.fullmatch(NAME_PATTERN, fields["name"]):
        raise _fault("name", "1 to 40 letters, digits, '-' or '_' are needed, a letter first", "bad_name")
    return MapSpec(
        name=fields["name"],
        title=_text(fields["title"], "title"),
        number=_whole(fields["number"], "number"),
        mode=_choice(fields["mode"], "mode", MODES),
        description=_text(fields["description"], "description"),
        robots=(_pose(robots["blue"], "robots.blue", _POSE), _pose(robots["red"], "robots.red", _POSE)),
        walls=_list(fields["walls"], "walls", _rect, 0, MAX_RECTS),
        goals=_list(fields["goals"], "goals", _rect, 1, MAX_RECTS),
        items=items,
        variant=_text(fields.get("variant", ""), "variant"),
    )


def checked_map(spec: MapSpec) -> MapSpec:
    """An equal map, of an object that others made: what a file may not hold, it may not either.

    Raises MapError, which names the map and the place in it, as for a file.
    """
    try:
        return map_from_json(map_to_json(spec))
    except MapDocumentError as error:
        raise MapError(f"{spec.name}: {error}") from error
    except (AttributeError, TypeError, ValueError) as error:  # of parts that are none: one robot, an item without pose
        raise MapError(f"{spec.name} is not made as MapSpec says: {error}") from error


def _pose_to_json(pose: Pose) -> dict[str, float]:
    return {"x": pose.x, "y": pose.y, "angle": pose.angle}


def _rect_to_json(rect: Rect) -> dict[str, float]:
    return {"x0": rect.x0, "y0": rect.y0, "x1": rect.x1, "y1": rect.y1}


def _item_to_json(item: ItemSpec) -> dict[str, Any]:
    return {
        "id": item.id,
        "shape": item.shape,
        "size": item.size,
        "scale": item.scale,
        "mass": item.mass,
        **_pose_to_json(item.pose),
    }


def _item(value: object, path: str) -> ItemSpec:
    fields = _object(value, path, _ITEM)
    return ItemSpec(
        id=_whole(fields["id"], f"{path}.id"),
        shape=_choice(fields["shape"], f"{path}.shape", SHAPES),
        size=_choice(fields["size"], f"{path}.size", SIZES),
        scale=_number(fields["scale"], f"{path}.scale", *SCALES),
        mass=_number(fields["mass"], f"{path}.mass", *MASSES),
        pose=_pose({key: fields[key] for key in _POSE}, path, _POSE),
    )


def _rect(value: object, path: str) -> Rect:
    fields = _object(value, path, _RECT)
    rect = Rect(*(_number(fields[key], f"{path}.{key}", -ARENA_HALF, ARENA_HALF) for key in _RECT))
    if rect.x0 == rect.x1 or rect.y0 == rect.y1:
        raise _fault(path, "the rectangle has no area; give two opposite corners", "no_area")
    return rect


def _pose(value: object, path: str, keys: tuple[str, ...]) -> Pose:
    fields = _object(value, path, keys)
    return Pose(
        x=_number(fields["x"], f"{path}.x", -ARENA_HALF, ARENA_HALF),
        y=_number(fields["y"], f"{path}.y", -ARENA_HALF, ARENA_HALF),
        angle=_number(fields["angle"], f"{path}.angle", -1000.0, 1000.0),
    )


def _object(value: object, path: str, keys: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise _fault(path, "an object is needed here", "no_object")
    for key in keys:
        if key not in value:
            raise _fault(path, f"{key!r} is missing", "missing", key=key)
    for key in value:
        if key not in keys and key not in optional:
            known = (*keys, *optional)
            what = f"unknown key {_quoted(key)}; known: {', '.join(known)}"
            raise _fault(path, what, "unknown_key", key=_json(key), known=known)
    return value


def _list(value: object, path: str, read: Callable[[object, str], _T], least: int, most: int) -> tuple[_T, ...]:
    if not isinstance(value, list):
        raise _fault(path, "a list is needed here", "no_list")
    if not least <= len(value) <= most:
        what = f"{least} to {most} entries are allowed, not {len(value)}"
        raise _fault(path, what, "entries", least=least, most=most, number=len(value))
    return tuple(read(entry, f"{path}[{index}]") for index, entry in enumerate(value))


def _number(value: object, path: str, least: float, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value or abs(value) == math.inf:
        raise _fault(path, f"a number is needed here, not {_quoted(value)}", "no_number", value=_json(value))
    if not least <= value <= most:
        what = f"{_quoted(value)} is outside {least:g} to {most:g}"
        raise _fault(path, what, "out_of_range", value=_json(value), least=least, most=most)
    return float(value)


def _whole(value: object, path: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        what = f"a whole number from 0 is needed here, not {_quoted(value)}"
        raise _fault(path, what, "no_whole_number", value=_json(value))
    return value


def _text(value: object, path: str) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise _fault(path, f"a text of at most {LONGEST_TEXT} characters is needed here", "no_text", most=LONGEST_TEXT)
    if re.search("[\ud800-\udfff]", value):  # of an emoji that was cut, in JSON "\ud83d": no page can be sent it
        raise _fault(path, "half of a character stands in this text; write it anew", "no_text", most=LONGEST_TEXT)
    return value


def _choice(value: object, path: str, choices: tuple[_T, ...]) -> _T:
    for choice in choices:
        if value == choice:
            return choice
    known = tuple(map(str, choices))
    what = f"{_quoted(value)} is unknown; known: {', '.join(known)}"
    raise _fault(path, what, "unknown_value", value=_json(value), known=known)


def _quoted(value: object) -> str:
    """A value as it stands in an error, not longer than a line."""
    return _cut(repr(value))


def _json(value: object) -> str:
    """A value as it stands in the document, not longer than a line."""
    return _cut(json.dumps(value, ensure_ascii=False, default=repr))


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST_QUOTE else f"{text[:_LONGEST_QUOTE]}…"


def _fault(path: str, what: str, code: DocumentFault, **values: object) -> MapDocumentError:
    return MapDocumentError(path or "the map", what, code, values)
