"""Styles of play, which people are grouped by: all who play one way against all who play another.

A list is a CSV file, participant,style. Without one, scripted people have theirs in their names: A01 to A20 are of
population A, whose habits are those of nobody in B and C.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from movingout.recordings.errors import RecordingError
from movingout.recordings.spreadsheet import read_rows

COLUMNS = ("participant", "style")
MIXED = "+"  # between the styles of two who played together
SHOWN = 5  # names in a message
_SCRIPTED = re.compile(r"([A-C])\d\d")
Styles = Mapping[str, str]
"""By participant; empty: the populations of scripted people."""


def read_styles(path: Path) -> dict[str, str]:
    """The style of each participant of a list. Raises RecordingError for a file that is no such list."""
    found: dict[str, str] = {}
    for number, row in read_rows(path, COLUMNS):
        one, style = (row[name].strip() for name in COLUMNS)
        if not (one and style):
            raise RecordingError(f"{path.name}, line {number}: both {' and '.join(COLUMNS)} are needed")
        if found.setdefault(one, style) != style:
            raise RecordingError(f"{path.name}, line {number}: {one} has style {found[one]!r} in an earlier line")
    if not found:
        raise RecordingError(f"{path.name} names nobody; its lines are participant,style")
    return found


def given_styles(path: Path | None, by: str, option: str = "--by style") -> dict[str, str]:
    """The styles that a command was given, none for those of scripted people.

    Raises RecordingError for a list that is none, or that nothing is grouped by.
    """
    if path is not None and by != "style":
        raise RecordingError(f"--styles says who plays how, which counts with {option} alone; add that")
    return {} if path is None else read_styles(path)


def styles_of(names: Iterable[str], listed: Styles) -> dict[str, str]:
    """The style of each participant. Raises RecordingError, with their names, where some have none."""
    people = sorted(set(names))
    if not people:
        raise RecordingError("no recording names its participants, so they cannot be grouped by style")
    found = {name: listed.get(name) if listed else _of_scripted(name) for name in people}
    missing = [name for name, style in found.items() if style is None]
    if missing:
        more = ", …" if len(missing) > SHOWN else ""
        raise RecordingError(
            f"{len(missing)} of {len(people)} participants have no style ({', '.join(missing[:SHOWN])}{more}); "
            "--styles FILE.csv says it, in lines participant,style"
        )
    return {name: style for name, style in found.items() if style is not None}


def style_of_pair(people: Sequence[str], styles: Styles) -> str:
    """The style of those who played together, or their styles with a plus; empty where nobody is named."""
    return MIXED.join(sorted({styles[name] for name in people}))


def _of_scripted(name: str) -> str | None:
    found = _SCRIPTED.fullmatch(name)
    return found[1] if found else None
