"""Who played trajectories that do not say so themselves, as the official data set: a CSV file trajectory_id,blue,red.

A trajectory is named by its own `trajectory_id`, by its 16 digits at the end of the recording's name, or by file and
place as the report has them: `demos.json episode 3`. Our own exports number `trajectory_id` anew on each map: a name
that several trajectories have is refused.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from movingout.recordings.errors import RecordingError
from movingout.recordings.imports.sources import TrajectoryFile
from movingout.recordings.spreadsheet import read_rows

COLUMNS = ("trajectory_id", "blue", "red")
Participants = Mapping[str, tuple[str, str]]


def read_participants(path: Path) -> Participants:
    """Who played blue and red, by trajectory. Raises RecordingError for a file that is no such list."""
    found: dict[str, tuple[str, str]] = {}
    for number, row in read_rows(path, COLUMNS):
        one, blue, red = (row[name].strip() for name in COLUMNS)
        if not (one and blue and red):
            raise RecordingError(f"{path.name}, line {number}: {', '.join(COLUMNS)} are needed, all three")
        if found.setdefault(one, (blue, red)) != (blue, red):
            raise RecordingError(f"{path.name}, line {number}: {one} was played by others, says an earlier line")
    return found


def with_participants(sources: Sequence[TrajectoryFile], who: Participants) -> list[TrajectoryFile]:
    """The trajectories with the names of the list; those that it lacks stay as they are.

    Raises RecordingError for a line that is of none of them, whose names would be lost, and for one that is of several.
    """
    named = [(source, next((name for name in _names(source) if name in who), "")) for source in sources]
    _check_single(named)
    unused = [name for name in who if name not in {used for _, used in named}]
    if unused:
        raise RecordingError(
            f"{unused[0]} is none of the trajectories ({len(unused)} such lines); name them by trajectory_id, by "
            f"the 16 digits at the end of a recording's name, or by file and place, as {_names(sources[0])[-1]!r}"
        )
    return [replace(source, blue=who[name][0], red=who[name][1]) if name else source for source, name in named]


def _check_single(named: Sequence[tuple[TrajectoryFile, str]]) -> None:
    """Raises RecordingError where a name is of several trajectories; copies of one, in other shapes, are one."""
    called: dict[str, list[TrajectoryFile]] = {}
    for source, name in named:
        if name:
            called.setdefault(name, []).append(source)
    for name, same in called.items():
        other = next((source for source in same[1:] if source.played != same[0].played), None)
        if other is not None:
            # the last name is file and place, which files of one name in two folders share
            one, two = (_names(source)[-1] for source in (same[0], other))
            one, two = (one, two) if one != two else (same[0].id, other.id)
            raise RecordingError(f"{name} names several trajectories; name each by itself, as {one!r} and {two!r}")


def _names(source: TrajectoryFile) -> list[str]:
    own = [source.trajectory_id] if source.trajectory_id else []
    return [*own, source.id, f"{source.file.name} {source.place}"]
