"""Cells of CSV files: no text of a person becomes a formula."""

import pytest

from movingout.recordings.spreadsheet import safe_cells, safe_text
from movingout.recordings.terminal import printable


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"])
def test_what_a_spreadsheet_takes_for_a_formula_gets_an_apostrophe(text: str) -> None:
    assert safe_text(text) == f"'{text}"


def test_other_text_and_numbers_stay() -> None:
    row = {"text": "1 = 1", "empty": "", "number": -3.5, "count": -1, "flag": False, "none": None}
    assert safe_cells(row) == row


def test_a_name_writes_nothing_on_the_terminal_but_letters() -> None:
    assert printable("Eve\x1b]0;owned\x07\x1b[2J\r\nP1\u202e") == "Eve�]0;owned��[2J��P1�"
    assert printable("Zoë 李 ✓") == "Zoë 李 ✓"
