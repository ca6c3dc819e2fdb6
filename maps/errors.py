"""The one base of every error that this project raises on purpose, and those of maps."""

from collections.abc import Mapping
from typing import Any, Literal

DocumentFault = Literal[
    "missing", "missing_part", "unknown_key", "no_object", "no_list", "entries", "no_number", "out_of_range",
    "no_whole_number", "no_text", "unknown_value", "no_area", "bad_name", "same_id", "format", "units", "official",
]  # fmt: skip


class MovingOutError(Exception):
    """Base of all expected errors. Its message says what was wrong and what would work."""


class MapError(MovingOutError):
    """A map is unknown, unreadable or faulty."""


class MapDocumentError(MapError):
    """A JSON document is no map: the path of the fault, a sentence, and both for programs with words of their own."""

    def __init__(self, path: str, message: str, code: DocumentFault, values: Mapping[str, Any]) -> None:
        super().__init__(path, message, code, values)
        self.path, self.message, self.code, self.values = path, message, code, values

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"
