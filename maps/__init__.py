"""The maps: what a level is, the 12 of the paper, checking and randomising them."""

from movingout.maps.errors import MapError, MovingOutError
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.maps.library import (
    PRACTICE,
    TUTORIAL,
    is_reserved,
    is_shipped,
    load_map,
    map_names,
    shipped_map_names,
)
from movingout.maps.spec import ItemSpec, MapSpec, Pose, Rect

__all__ = [
    "PRACTICE",
    "TUTORIAL",
    "ItemSpec",
    "MapError",
    "MapSpec",
    "MovingOutError",
    "Pose",
    "Rect",
    "is_reserved",
    "is_shipped",
    "load_map",
    "map_from_json",
    "map_names",
    "map_to_json",
    "shipped_map_names",
]
