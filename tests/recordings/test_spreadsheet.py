"""Cells of CSV files: no text of a person becomes a formula."""

import pytest

from movingout.recordings.spreadsheet import safe_cells, safe_text


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"])
def test_what_a_spreadsheet_takes_for_a_formula_gets_an_apostrophe(text: str) -> None:
    assert safe_text(text) == f"'{text}"


def test_other_text_and_numbers_stay() -> None:
    row = {"text": "1 = 1", "empty": "", "number": -3.5, "count": -1, "flag": False, "none": None}
    assert safe_cells(row) == row
