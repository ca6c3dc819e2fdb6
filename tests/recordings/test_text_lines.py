"""Files of lines that only grow."""

from pathlib import Path

import pytest

from movingout.recordings.text_lines import append_line, read_lines

BREAKS = "a\u2028b\u2029c\x85d\x0be\x0cf\x1cg\rh"


def test_other_breaks_than_the_line_feed_stay_in_a_line(tmp_path: Path) -> None:
    file = tmp_path / "lines"
    assert [append_line(file, line) for line in (BREAKS, "next")] == [True, True]
    assert read_lines(file) == [BREAKS, "next"]


@pytest.mark.parametrize("left", [b'{"text": "half', b'{"text": "h\xc3'])
def test_what_a_full_disk_left_of_a_line_takes_no_other_with_it(tmp_path: Path, left: bytes) -> None:
    file = tmp_path / "lines"
    append_line(file, "one")
    with file.open("ab") as stream:
        stream.write(left)
    append_line(file, "two")
    lines = read_lines(file)
    assert (lines[0], len(lines), lines[2]) == ("one", 3, "two")


def test_a_file_grows_to_its_limit_in_bytes(tmp_path: Path) -> None:
    file = tmp_path / "lines"
    assert append_line(file, "\u4e00" * 3, most_bytes=10)
    assert not append_line(file, "", most_bytes=10)
    assert file.stat().st_size == 10
