"""Reads map files of the official environment (live-robotics-uva/movingout_env) as they are.

Only what the physics needs is taken; colours and hold flags mean nothing here.
"""

import re
from typing import Any

from movingout.maps.errors import MapError
from movingout.maps.json_format import FORMAT, map_from_json
from movingout.maps.spec import MapSpec


def is_official(document: object) -> bool:
    """Whether a JSON document looks like an official map file."""
    return isinstance(document, dict) and "robot_1_pos" in document and "format" not in document


def map_from_official(document: dict[str, Any], stem: str) -> MapSpec:
    """The map of an official file; its name is the file's stem without the leading number. Raises MapError."""
    name = re.sub(r"[^A-Za-z0-9_-]", "_", re.sub(r"^\d+_", "", stem))[:40] or "Map"
    name = name if name[0].isalpha() else f"Map{name}"[:40]
    try:
        ours = {
            "format": FORMAT,
            "name": name,
            "title": name,
            "number": 0,
            "mode": "practice",
            "description": "Read from a map file in the official format.",
            "robots": {"blue": _robot(document, 1), "red": _robot(document, 2)},
            "walls": [_rect(wall) for wall in document["walls"] if wall != [None]],
            "goals": [_rect(area) for area in document["target_areas"]],
            "items": [_item(int(key), value) for key, value in _by_id(document["items"]) if value is not None],
        }
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise MapError(
            f"not an official map file: {type(error).__name__} {error}; needed are robot_1_pos, robot_1_angle, "
            "robot_2_pos, robot_2_angle, walls, target_areas and items"
        ) from error
    return map_from_json(ours)


def _by_id(items: dict[str, Any]) -> list[tuple[str, Any]]:
    return sorted(items.items(), key=lambda entry: int(entry[0]))


def _robot(document: dict[str, Any], number: int) -> dict[str, Any]:
    x, y = document[f"robot_{number}_pos"]
    return {"x": x, "y": y, "angle": document[f"robot_{number}_angle"]}


def _rect(corners: Any) -> dict[str, Any]:
    (x0, y0), (x1, y1) = corners
    return {"x0": x0, "y0": y0, "x1": x1, "y1": y1}


def _item(item_id: int, item: dict[str, Any]) -> dict[str, Any]:
    x, y = item["pos"]
    return {
        "id": item_id,
        "shape": item["shape"],
        "size": item["size"],
        "scale": item["shape_scale"],
        "mass": item["mass"],
        "x": x,
        "y": y,
        "angle": item["angle"],
    }
