"""Whether a JSON document is a map that can be played: what makes it unreadable or, if it can be read, unplayable."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from movingout.maps.check import MapFault, check_map
from movingout.maps.errors import MapDocumentError
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.maps.library import PRACTICE, load_map


def check_document(document: object) -> tuple[MapFault, ...]:
    """All faults of a JSON document in our format: what makes it unreadable or, if it can be read, unplayable."""
    try:
        return check_map(map_from_json(document))
    except MapDocumentError as error:
        first = fault_of(error)
    faults = list(_unreadable(document)) if isinstance(document, dict) else []
    return tuple(faults or [first])


def _unreadable(document: dict[str, Any]) -> Iterator[MapFault]:
    """Each part is read in the place of the same part of a sound map, so that one fault does not hide the next."""
    sound = map_to_json(load_map(PRACTICE))
    for key in sound:
        if key not in document and key != "units":
            yield MapFault(key, "is missing", "missing_part")
    for key, value in document.items():
        entries = value if key in ("walls", "goals", "items") and isinstance(value, list) and value else [value]
        for index, entry in enumerate(entries):
            try:
                map_from_json({**sound, key: [entry] if entries is value else entry})
            except MapDocumentError as error:
                fault = fault_of(error)
                yield replace(fault, path=fault.path.replace(f"{key}[0]", f"{key}[{index}]", 1))


def fault_of(error: MapDocumentError) -> MapFault:
    return MapFault(error.path, error.message, error.code, error.values)
