"""Which given episodes the tables are made from: of people where there are any, on the maps of the paper."""

import sys
from collections.abc import Collection, Sequence
from pathlib import Path

from movingout.agents.data.dataset import has_person
from movingout.maps.suggestion import counted
from movingout.matches.errors import MatchError
from movingout.recordings.storage.listing import read_players, read_summary


def with_people(paths: Sequence[Path], given: Sequence[Path]) -> list[Path]:
    """The episodes with a person in them, all where no `given` one has any; how many are left out is printed.

    Agents are no participants, and are not imitated for people. Raises MatchError where none is left.
    """
    if not any(_has_person(path) for path in given):
        return list(paths)
    why = "nobody but agents plays in them, and other recordings of --data have people"
    return _kept(paths, [path for path in paths if _has_person(path)], why)


def on_paper_maps(paths: Sequence[Path], names: Collection[str]) -> list[Path]:
    """The episodes on maps of these names; how many are left out is printed. Raises MatchError where none is left."""
    maps = {path: read_summary(path).map for path in paths}
    others = sorted(set(maps.values()).difference(names))
    why = f"they are on other maps than the paper's twelve ({', '.join(others)})"
    return _kept(paths, [path for path in paths if maps[path] in names], why)


def _has_person(path: Path) -> bool:
    return has_person([seat.kind for seat in read_players(path).seats])


def _kept(paths: Sequence[Path], kept: list[Path], why: str) -> list[Path]:
    if len(kept) == len(paths):
        return kept
    sentence = f"{len(paths) - len(kept)} of {counted(len(paths), 'episode')} cannot be learned from: {why}"
    if not kept:
        raise MatchError(sentence)
    sys.stderr.write(f"movingout: {sentence}\n")
    return kept
