"""CSV files: no text of a person becomes a formula, and lists are read as any spreadsheet saves them."""

import csv
from pathlib import Path

import pytest

from movingout.recordings.errors import RecordingError
from movingout.recordings.spreadsheet import read_rows, safe_cells, safe_text


@pytest.mark.parametrize(
    "text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "＝1+1", "＋1", "－1", "＠SUM(A1)", "﹦1"]
)
def test_what_a_spreadsheet_takes_for_a_formula_gets_an_apostrophe(text: str) -> None:
    assert safe_text(text) == f"'{text}"


def test_other_text_and_numbers_stay() -> None:
    row = {"text": "1 = 1", "empty": "", "number": -3.5, "count": -1, "flag": False, "none": None}
    assert safe_cells(row) == row


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize(("encoding", "newline"), [("utf-8", "\n"), ("utf-8-sig", "\r\n")])
def test_lists_are_read_as_spreadsheets_of_any_country_save_them(
    tmp_path: Path, delimiter: str, encoding: str, newline: str
) -> None:
    file = tmp_path / "list.csv"
    rows = [["who", "note", " style"], ["Ada", "a, b; c\td", "leads"], ["", "", ""], ["Bö", ""]]
    with file.open("w", encoding=encoding, newline="") as stream:
        csv.writer(stream, delimiter=delimiter, lineterminator=newline).writerows(rows)
    assert read_rows(file, ("who", "style")) == [
        (2, {"who": "Ada", "note": "a, b; c\td", "style": "leads"}),
        (4, {"who": "Bö", "note": "", "style": ""}),
    ]


@pytest.mark.parametrize(
    ("written", "sentence"),
    [
        (b"", "has no column who; its first line names the columns who, style, with commas, semicolons or tabs"),
        (b"who;styles\nAda;leads\n", "has no column style;"),
        ("who;style\nBö;leads\n".encode("cp1252"), "is not UTF-8 text; save it as “CSV UTF-8”"),
        (b"who,style\n" + b"x" * 200_000, "is not a table in CSV"),
    ],
)
def test_a_file_that_is_no_such_list_is_refused_with_what_it_needs(
    tmp_path: Path, written: bytes, sentence: str
) -> None:
    file = tmp_path / "list.csv"
    file.write_bytes(written)
    with pytest.raises(RecordingError, match=f"list.csv {sentence}"):
        read_rows(file, ("who", "style"))
