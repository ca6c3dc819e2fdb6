"""Lists that people write: a text file with one name per line, given as `@FILE` where one name would stand."""

from pathlib import Path

from movingout.maps.files.input_file import read_input

LIST = "@"  # before the path
COMMENT = "#"


def listed_lines(path: Path) -> list[tuple[int, str]]:
    """The lines that say something, with their numbers from 1; those that begin with # are comments.

    Raises OSError for a file that cannot be read, ValueError for one that is no text.
    """
    lines = enumerate(read_input(path).decode("utf-8-sig").splitlines(), start=1)
    said = ((number, line.strip()) for number, line in lines)
    return [(number, line) for number, line in said if line and not line.startswith(COMMENT)]
