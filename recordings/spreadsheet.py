"""CSV files that a spreadsheet opens: their names, and cells in which text of people must not be read as a formula."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from movingout.recordings.errors import RecordingError

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def safe_text(text: str) -> str:
    """Text with a leading apostrophe where a spreadsheet would take it for a formula."""
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def safe_cells(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with safe texts; numbers, also negative ones, stay what they are."""
    return {name: safe_text(value) if isinstance(value, str) else value for name, value in row.items()}


def check_name(path: Path) -> None:
    """RecordingError unless the name ends in .csv, so that a typing error does not overwrite a recording."""
    if path.suffix.lower() != ".csv":
        raise RecordingError(f"{path} is not the name of a table; it should end in .csv")
