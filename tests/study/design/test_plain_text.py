"""Texts of studies that earlier versions kept, with what Windows wrote into the files that they name."""

import pytest

from movingout.study.design.study_file import plain_text


@pytest.mark.parametrize(
    ("kept", "plain"),
    [
        (r'text: "# Consent\r\nWe record."', r'text: "# Consent\nWe record."'),
        ("\ufeff" + r'{a: "\U0000feffOne\r\n", "b": "Two\r\n"}', r'{a: "One\n", "b": "Two\n"}'),
        (r"text: path C:\r\new", None),
        (r"text: 'path \"C:\r\new\"'", None),
        (r'text: "a backslash \\r\nnew"', None),
        ("text: |\n  path C:\\r\\new", None),
        (r"text: [C:\r\new", None),
    ],
)
def test_only_ends_of_lines_that_windows_wrote_into_texts_of_files_are_made_plain(kept: str, plain: str | None) -> None:
    assert plain_text(kept) == (kept if plain is None else plain)
