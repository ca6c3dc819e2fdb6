"""A text file of lines that only grows: one line is appended and on the disk before anybody hears that it is kept."""

import os
from pathlib import Path

from movingout.maps.files.ownership import give_to_owner_of_folder


def append_line(path: Path, line: str, most_bytes: int | None = None) -> bool:
    """Append and fsync; False where the file would exceed `most_bytes`. Raises OSError.

    What a full disk or a crash has left of an earlier line gets an end of its own first.
    """
    with path.open("ab+") as stream:
        size = stream.tell()
        begun = b""
        if size:
            stream.seek(-1, os.SEEK_END)
            begun = stream.read(1).replace(b"\n", b"")
        data = (b"\n" if begun else b"") + line.encode(errors="surrogateescape") + b"\n"
        if most_bytes is not None and size + len(data) > most_bytes:
            return False
        if not size:
            give_to_owner_of_folder(path)
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())
    return True


def read_lines(path: Path) -> list[str]:
    """The lines; a text in one may have any other break, such as U+2028. Raises OSError.

    A line that was cut short ends in half a letter: that becomes U+FFFD.
    """
    return [line for line in path.read_bytes().decode(errors="replace").split("\n") if line]
