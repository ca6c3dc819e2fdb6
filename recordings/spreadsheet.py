"""CSV files that spreadsheets open and save: their names, cells that are no formulas, and how lists are read."""

import csv
import io
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from movingout.maps.files.input_file import read_input
from movingout.recordings.errors import RecordingError, cannot

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
ENCODING = "utf-8-sig"  # with a mark at the beginning, without which Excel shows "±" as "Â±"
DELIMITERS = (",", ";", "\t")  # a spreadsheet saves the second where decimals have a comma


def safe_text(text: str) -> str:
    """Text with a leading apostrophe where a spreadsheet would take it for a formula.

    Also for signs of another width, such as `＝`: some spreadsheets make them the plain ones when a file is opened.
    """
    return f"'{text}" if unicodedata.normalize("NFKC", text[:1]).startswith(FORMULA_STARTS) else text


def safe_cells(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with safe texts; numbers, also negative ones, stay what they are."""
    return {name: safe_text(value) if isinstance(value, str) else value for name, value in row.items()}


def check_name(path: Path) -> None:
    """Raises RecordingError unless the name ends in .csv, so that a typing error does not overwrite a recording."""
    if path.suffix.lower() != ".csv":
        raise RecordingError(f"{path} is not the name of a table; it should end in .csv")


def read_rows(path: Path, needed: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """The rows of a CSV file by column, each with the number of its line; cells that are missing are empty.

    The delimiter is the one that finds most of the columns that are `needed` in the header. Rows without any text,
    which spreadsheets leave behind, are left out. Raises RecordingError.
    """
    try:
        text = read_input(path).decode("utf-8-sig")
    except OSError as error:
        raise cannot("read", path, error) from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path.name} is not UTF-8 text; save it as “CSV UTF-8”") from error
    try:
        return list(_rows(path, text, needed))
    except csv.Error as error:
        raise RecordingError(f"{path.name} is not a table in CSV ({error}); save it as “CSV UTF-8”") from error


def _rows(path: Path, text: str, needed: Sequence[str]) -> Iterator[tuple[int, dict[str, str]]]:
    columns, rows = max((_read(text, one) for one in DELIMITERS), key=lambda read: len({*needed} & {*read[0]}))
    missing = [name for name in needed if name not in columns]
    if missing:
        raise RecordingError(
            f"{path.name} has no column {missing[0]}; its first line names the columns {', '.join(needed)}, "
            "with commas, semicolons or tabs between them"
        )
    for cells in rows:
        if any(cells):
            filled = [*cells, *[""] * (len(columns) - len(cells))]
            yield rows.line_num, dict(zip(columns, filled, strict=False))


def _read(text: str, delimiter: str) -> tuple[list[str], Any]:
    """The names of the columns, and the reader of what follows them."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    return [name.strip() for name in next(reader, [])], reader
