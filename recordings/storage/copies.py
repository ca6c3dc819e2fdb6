"""One file of each episode: copies of files, and imported episodes that were exported from recordings beside them."""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import orjson

from movingout.maps.files.input_file import open_input
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.metadata import RECORDING
from movingout.recordings.file_format.payloads import read_state
from movingout.recordings.file_format.reader import UNREADABLE, read_episode
from movingout.recordings.file_format.records import messages_since
from movingout.recordings.file_format.topics import CHANNELS, TICK_NS
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_metadata, read_summary, recorded_as
from movingout.world.state import Floats

ROUNDED = 1e-3  # arena units or rad; exported numbers may have been rounded to three decimals
PROOF_TICKS = 10  # 1 s: what is shorter may have been played alike by others
SECOND_NS = 1_000_000_000  # official files say to the second when they were recorded


class _File(NamedTuple):
    path: Path
    episode_id: str
    started: str
    source: str = ""
    map: str = ""
    ticks: int = 0
    variant: str = ""


def without_copies(paths: Sequence[Path]) -> list[Path]:
    """One file of each episode, in order: a backup in a folder below is no second play. Unreadable ones stay.

    Copies have the same id and began at the same time: what was made twice under one id is there twice. Of copies it
    is a recording before a journal, a whole one before one that was cut off, an import on a map as designed before one
    on a varied map, one that is named by its episode before one that was renamed, else the first. An imported episode
    is a copy of a recording, or of an import in another folder, that equals it action by action; where nobody did
    anything, or for less than a second, it also says that it was recorded in the same second.
    """
    files: dict[tuple[str, str], list[_File]] = defaultdict(list)
    for file in _readable(paths):
        files[file.episode_id, file.started].append(file)
    found: set[Path] = set()
    for (episode_id, _), alike in files.items():
        if len(alike) > 1:
            ranks = [_rank(file, f"{episode_id}{SUFFIX}") for file in alike]
            found |= {file.path for file in alike} - {alike[ranks.index(min(ranks))].path}
    found |= _imported_copies(file for alike in files.values() for file in alike if file.path not in found)
    return [path for path in paths if path not in found]


def imports_of(recordings: Iterable[Path], imports: Iterable[Path]) -> set[Path]:
    """Those of the imports that equal one of the recordings, wherever they are, as `without_copies` says."""
    by_map: dict[str, tuple[list[_File], list[_File]]] = defaultdict(lambda: ([], []))
    for number, paths in enumerate((recordings, imports)):
        for file in _readable(paths):
            by_map[file.map][number].append(file)
    return set[Path]().union(*(_copies_on_a_map(*there, of_imports=False) for there in by_map.values()))


def _readable(paths: Iterable[Path]) -> Iterator[_File]:
    for path in paths:
        with suppress(RecordingError):  # whoever reads it says so
            yield _file(path)


def _file(path: Path) -> _File:
    if path.name.endswith(JOURNAL_SUFFIX):
        header = read_episode(path).header
        return _File(path, header.episode_id, str(header.started_ns))
    records = read_metadata(path)
    record = recorded_as(path, records)
    ticks = records.get(RECORDING, {}).get("ticks", "")
    return _File(
        path=path,
        episode_id=record.get("episode_id", ""),
        started=record.get("started_ns", ""),
        source=record.get("source", ""),
        map=record.get("map", ""),
        ticks=int(ticks) if ticks.isdecimal() else 0,
        variant=record.get("map_variant", ""),
    )


def _rank(file: _File, named: str) -> tuple[bool, bool, bool, bool]:
    """Of a copy, the best first."""
    try:
        complete = read_summary(file.path).complete
    except RecordingError:
        complete = False
    return file.path.name.endswith(JOURNAL_SUFFIX), not complete, _is_varied(file), file.path.name != named


def _is_varied(file: _File) -> bool:
    """Whether it was imported as on a varied map, maybe for numbers that are rounded: earlier versions did so."""
    return file.source == "import" and file.variant != ""


def _imported_copies(files: Iterable[_File]) -> set[Path]:
    """Imports that equal something else. In one folder alone there are none: `recordings import` sees to that."""
    by_map: dict[str, list[_File]] = defaultdict(list)
    for file in files:
        by_map[file.map].append(file)
    found: set[Path] = set()
    for there in by_map.values():
        imports = sorted((file for file in there if file.source == "import"), key=_is_varied)
        others = [file for file in there if file.source != "import"]
        if imports and (others or len({file.path.parent for file in imports}) > 1):
            found |= _copies_on_a_map(others, imports)
    return found


def _copies_on_a_map(others: Sequence[_File], imports: Sequence[_File], of_imports: bool = True) -> set[Path]:
    """The imports that are copies of others, or, with `of_imports`, of each other."""
    near = {file.ticks + more for file in imports for more in (-1, 0, 1)}
    by_end: dict[_End, list[_Play]] = defaultdict(list)
    found: set[Path] = set()
    for file in (*others, *imports):
        if file.ticks not in near:
            continue
        play = _Play(file)
        ends = play.ends()
        if file.source == "import" and any(map(play.is_copy_of, _alike(ends, by_end))):
            found.add(file.path)
        elif of_imports or file.source != "import":
            for end in ends:
                by_end[end].append(play)
    return found


_End = tuple[int, int]
"""A tick near the end of an episode, and about where everything was before it: in units of ROUNDED."""


def _alike(ends: Sequence[_End], by_end: Mapping[_End, "list[_Play]"]) -> list["_Play"]:
    """Plays that ended where one with these `ends` did, each once."""
    near = [(tick, place + more) for tick, place in ends for more in (-1, 0, 1)]
    return list({id(play): play for end in near for play in by_end.get(end, ())}.values())


class _Play:
    """An episode of which only as much is read as it takes to tell it from another."""

    def __init__(self, file: _File) -> None:
        self._file = file
        self._poses: dict[int, Floats] = {}  # before each of the last two ticks, (6 + 3 N,)
        with suppress(OSError, *UNREADABLE):  # whoever reads it says so
            self._poses = _last_poses(file)

    def ends(self) -> list[_End]:
        """What plays have in common of which all poses differ by at most ROUNDED: the places by one at most."""
        return [(tick, math.floor(poses.mean() / ROUNDED)) for tick, poses in self._poses.items()]

    def is_copy_of(self, other: "_Play") -> bool:
        """Whether the same was played there, maybe rounded; an import may lack the last tick."""
        file, another = self._file, other._file
        beside = another.source == "import" and another.path.parent == file.path.parent
        ticks = min(file.ticks, another.ticks)
        if beside or max(file.ticks, another.ticks) > ticks + 1 or not self._ends_like(other, ticks - 1):
            return False
        one, two = self._numbers[:ticks], other._numbers[:ticks]
        return _is_close(one, two) and (_is_proof(one) or _second(file) == _second(another))

    def _ends_like(self, other: "_Play", tick: int) -> bool:
        one, two = self._poses.get(tick), other._poses.get(tick)
        return one is not None and two is not None and _is_close(one, two)

    @cached_property
    def _numbers(self) -> Floats:
        """Actions and the poses before them, (T, 12 + 3 N); none (0, 0) where they cannot be read."""
        try:
            return _numbers(read_episode(self._file.path))
        except RecordingError:
            return np.empty((0, 0))


def _last_poses(file: _File) -> dict[int, Floats]:
    """The poses before each of the last two ticks; only the end of the file is read. Raises OSError, UNREADABLE."""
    since = int(file.started) + max(file.ticks - 2, 0) * TICK_NS
    with open_input(file.path) as stream:
        messages = [one for one in messages_since(stream, since) if one.channel_id == CHANNELS["/state"]]
    states = [read_state(orjson.loads(one.data))[0] for one in messages]
    return {one.tick: np.concatenate([one.robot_poses, one.item_poses]).ravel() for one in states[:-1]}


def _numbers(episode: Episode) -> Floats:
    before = episode.states[:-1]
    pressed = np.concatenate([episode.actions[..., :2], episode.actions[..., 2:] > 0.5], axis=-1)
    robots, items = np.array([state.robot_poses for state in before]), np.array([state.item_poses for state in before])
    return np.concatenate([part.reshape(len(pressed), -1) for part in (pressed, robots, items)], axis=1)


def _is_close(one: Floats, two: Floats) -> bool:
    return one.size > 0 and one.shape == two.shape and bool((np.abs(one - two) <= ROUNDED).all())


def _is_proof(numbers: Floats) -> bool:
    """Whether others would hardly have played the same: somebody walked or pressed, and for long enough."""
    return len(numbers) >= PROOF_TICKS and bool(numbers[:, [0, 2, 3, 5]].any())


def _second(file: _File) -> int:
    return int(file.started) // SECOND_NS
