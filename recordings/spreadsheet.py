"""Cells of CSV files that a spreadsheet opens: text from people must not be read as a formula."""

from collections.abc import Mapping
from typing import Any

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def safe_text(text: str) -> str:
    """Text with a leading apostrophe where a spreadsheet would take it for a formula."""
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def safe_cells(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with safe texts; numbers, also negative ones, stay what they are."""
    return {name: safe_text(value) if isinstance(value, str) else value for name, value in row.items()}
