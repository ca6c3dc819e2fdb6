"""Lists that people write: comments, blank lines and the line ends of every editor."""

from pathlib import Path

from movingout.maps.files.list_file import listed_lines


def test_lines_that_say_something_keep_their_numbers(tmp_path: Path) -> None:
    file = tmp_path / "list.txt"
    file.write_bytes("\ufeff# mine\r\n\r\n  HandOff \r\nmy maps/Größe.json".encode())
    assert listed_lines(file) == [(3, "HandOff"), (4, "my maps/Größe.json")]
