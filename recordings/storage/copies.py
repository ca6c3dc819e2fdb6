"""One file of each episode: copies of files, and imported episodes that were exported from recordings beside them."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_metadata, read_summary, recorded_as
from movingout.world.state import Floats

ROUNDED = 1e-4  # arena units or rad; exported numbers may have been rounded to four decimals
SAME_NFD = 0.01  # of episodes of as many ticks; rounded positions change it by less


class _File(NamedTuple):
    path: Path
    episode_id: str
    started: str
    source: str = ""
    map: str = ""


def without_copies(paths: Sequence[Path]) -> list[Path]:
    """One file of each episode, in order: a backup in a folder below is no second play. Unreadable ones stay.

    Copies have the same id and began at the same time: what was made twice under one id is there twice. Of copies it
    is a recording before a journal, a whole one before one that was cut off, one that is named by its episode before
    one that was renamed, else the first. An imported episode is a copy of a recording, or of an import in another
    folder, that equals it action by action.
    """
    files: dict[tuple[str, str], list[_File]] = defaultdict(list)
    for path in paths:
        with suppress(RecordingError):  # whoever reads it says so
            file = _file(path)
            files[file.episode_id, file.started].append(file)
    found: set[Path] = set()
    for (episode_id, _), alike in files.items():
        if len(alike) > 1:
            ranks = [_rank(file.path, f"{episode_id}{SUFFIX}") for file in alike]
            found |= {file.path for file in alike} - {alike[ranks.index(min(ranks))].path}
    found |= _imported_copies(file for alike in files.values() for file in alike if file.path not in found)
    return [path for path in paths if path not in found]


def _file(path: Path) -> _File:
    if path.name.endswith(JOURNAL_SUFFIX):
        header = read_episode(path).header
        return _File(path, header.episode_id, str(header.started_ns))
    record = recorded_as(path, read_metadata(path))
    return _File(path, *(record.get(name, "") for name in ("episode_id", "started_ns", "source", "map")))


def _rank(path: Path, named: str) -> tuple[bool, bool, bool]:
    """Of a copy, the best first."""
    try:
        complete = read_summary(path).complete
    except RecordingError:
        complete = False
    return path.name.endswith(JOURNAL_SUFFIX), not complete, path.name != named


def _imported_copies(files: Iterable[_File]) -> set[Path]:
    """Imports that equal something else. In one folder alone there are none: `recordings import` sees to that."""
    by_map: dict[str, list[_File]] = defaultdict(list)
    for file in files:
        by_map[file.map].append(file)
    found: set[Path] = set()
    for there in by_map.values():
        imports = [file.path for file in there if file.source == "import"]
        others = [file.path for file in there if file.source != "import"]
        if imports and (others or len({path.parent for path in imports}) > 1):
            found |= _copies_on_a_map(others, imports)
    return found


def _copies_on_a_map(others: Sequence[Path], imports: Sequence[Path]) -> set[Path]:
    by_ticks: dict[int, list[_Play]] = defaultdict(list)
    found: set[Path] = set()
    for path, imported in (*((path, False) for path in others), *((path, True) for path in imports)):
        with suppress(RecordingError):
            play = _Play(path, imported)
            near = [one for ticks in range(play.ticks - 1, play.ticks + 2) for one in by_ticks[ticks]]
            if imported and any(map(play.is_copy_of, near)):
                found.add(path)
            else:
                by_ticks[play.ticks].append(play)
    return found


class _Play:
    """An episode of which only as much is read as it takes to tell it from another."""

    def __init__(self, path: Path, imported: bool) -> None:
        summary = read_summary(path)
        self.path, self.ticks, self.imported = path, summary.ticks, imported
        self._nfd, self._items = summary.metrics["nfd"], summary.metrics["items"]
        self._numbers: Floats | None = None

    def is_copy_of(self, other: "_Play") -> bool:
        """Whether the same was played there, maybe rounded; an import may lack the last tick."""
        beside = other.imported and other.path.parent == self.path.parent
        if beside or self._items != other._items or self._differs_in_summary(other):
            return False
        one, another = self.numbers(), other.numbers()
        ticks = min(len(one), len(another))
        return ticks > 0 and np.allclose(one[:ticks], another[:ticks], rtol=0.0, atol=ROUNDED)

    def _differs_in_summary(self, other: "_Play") -> bool:
        known = self._nfd is not None and other._nfd is not None and self.ticks == other.ticks
        return known and abs((self._nfd or 0.0) - (other._nfd or 0.0)) > SAME_NFD

    def numbers(self) -> Floats:
        """Actions and the poses before them, (T, 12 + 3 N); none (0, 0) where they cannot be read."""
        if self._numbers is None:
            self._numbers = np.empty((0, 0))
            with suppress(RecordingError):
                self._numbers = _numbers(read_episode(self.path))
        return self._numbers


def _numbers(episode: Episode) -> Floats:
    before = episode.states[:-1]
    pressed = np.concatenate([episode.actions[..., :2], episode.actions[..., 2:] > 0.5], axis=-1)
    robots, items = np.array([state.robot_poses for state in before]), np.array([state.item_poses for state in before])
    return np.concatenate([part.reshape(len(pressed), -1) for part in (pressed, robots, items)], axis=1)
