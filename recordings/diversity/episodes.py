"""Recordings and official files as paths, and the populations that they are grouped into."""

import os
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from movingout.maps.files.map_versions import numbered_map, numbered_maps, one_name_sentence
from movingout.maps.spec import MapSpec
from movingout.recordings.episode import FINISHED, Episode, SeatInfo, player_label
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.split import participants
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.imports.convert import import_source
from movingout.recordings.imports.sources import SUFFIXES, find, read, without_copies
from movingout.recordings.progress import map_in_processes
from movingout.recordings.storage import copies as recorded_copies
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import Players, Unreadable
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.recordings.styles import Styles, style_of_pair, styles_of
from movingout.world.state import Floats

ALL = "all together"


@dataclass(frozen=True, slots=True, eq=False)
class PathEpisode:
    """Where both robots of one episode were."""

    map: MapSpec
    place: str  # the file or folder that it was named by
    source: str  # live, match, scripted, import
    seats: tuple[SeatInfo, SeatInfo]
    path: Floats  # (T + 1, 4) x, y of blue and red
    file: str  # which it was read from, links followed
    simulated: bool = False  # in a rehearsal of a study: its participants were programs
    content: Any = None  # what `read_paths` was told to keep of it

    @property
    def people(self) -> tuple[str, ...]:
        """The people of the episode, or its agents where no person took part."""
        return participants(Players("", self.seats))


class Reading(NamedTuple):
    """What was found, and how much of it is of no use."""

    episodes: list[PathEpisode]
    unfinished: int
    tutorials: int
    unreadable: list[Unreadable]
    uncounted: int = 0  # which their study leaves out
    copies: int = 0  # of recordings at the same place, or at any place, where those are left out


def read_paths(
    places: Sequence[Path], workers: int, by_place: bool = False, content: Callable[[Episode], Any] | None = None
) -> Reading:
    """The finished episodes under each place: recordings, or official files where there are none.

    Left out are copies, and what a study beside the recordings does not count. A place that is named twice is read
    once. A file under two places belongs to the first, and of copies under two places one stays; `by_place` each
    place has its own. `content` makes of each episode what is kept of it besides; it can be pickled, as can what it
    makes. Raises RecordingError when a place holds neither.
    """
    found = Reading([], 0, 0, [])
    unfinished = tutorials = 0
    with tempfile.TemporaryDirectory() as folder:  # of all places: an official trajectory under two of them is one file
        there = {place: _recordings(place, Path(folder), workers) for place in _named_once(places)}
        counted = _counted(there)
        once = _once_each(counted) if by_place else _once(counted)
        for place, files in once.items():
            for one in map_in_processes(partial(_path_episode, str(place), content), files, workers, "reading"):
                match one:
                    case PathEpisode():
                        found.episodes.append(one)
                    case Unreadable():
                        found.unreadable.append(one)
                    case "tutorial":
                        tutorials += 1
                    case _:
                        unfinished += 1
    uncounted, copies = _number(there) - _number(counted), _number(counted) - _number(once)
    return found._replace(unfinished=unfinished, tutorials=tutorials, uncounted=uncounted, copies=copies)


def _named_once(places: Sequence[Path]) -> list[Path]:
    first: dict[str, Path] = {}
    for place in places:
        first.setdefault(os.path.realpath(place), place)
    return list(first.values())


_Places = dict[Path, list[Path]]  # the files under each place


def _number(places: _Places) -> int:
    return sum(map(len, places.values()))


def _counted(places: _Places) -> _Places:
    """Without what a study beside any of the places does not count."""
    kept = set(counted_recordings([file for files in places.values() for file in files]))
    return {place: [file for file in files if file in kept] for place, files in places.items()}


def _once_each(places: _Places) -> _Places:
    """One file of each episode at each place."""
    return {place: recorded_copies.without_copies(files) for place, files in places.items()}


def _once(places: _Places) -> _Places:
    """One file of each episode, and that at one place; a file at several is at the first."""
    new: dict[str, Path] = {}
    for file in (file for files in places.values() for file in files):
        new.setdefault(os.path.realpath(file), file)
    left = set(recorded_copies.without_copies(list(new.values())))
    found: _Places = {}
    for place, files in places.items():
        found[place] = [file for file in files if file in left]
        left -= set(files)
    return found


def _recordings(place: Path, folder: Path, workers: int) -> list[Path]:
    """The recordings of a place; official files become recordings in `folder`, or are there from an earlier place."""
    if not place.exists():
        raise RecordingError(f"there is nothing at {place}; check the name")
    files = sorted(place.rglob(f"*{SUFFIX}")) if place.is_dir() else [place] if place.suffix == SUFFIX else []
    if files:
        return files
    if place.is_dir() and not any(one.suffix in SUFFIXES for one in place.rglob("*")):
        raise RecordingError(
            f"there are no recordings in {place}: neither *{SUFFIX} nor official *{', *'.join(SUFFIXES)}"
        )
    sources = without_copies([source for file in find([place]) for source in read(file)])
    convert = partial(import_source, folder=folder, salt="diversity")
    reports = list(map_in_processes(convert, sources, workers, "importing"))
    made = sorted({folder / report.recording for report in reports if report.recording})
    if not made:
        raise RecordingError(f"no trajectory of {place} can be used: {reports[0].problem}")
    return made


def _path_episode(place: str, content: Callable[[Episode], Any] | None, file: Path) -> PathEpisode | Unreadable | str:
    """An episode, or why it is left out: unreadable, "tutorial" or "unfinished"."""
    try:
        episode = read_episode(file)
    except RecordingError as error:
        return Unreadable(file, str(error))
    header = episode.header
    if header.source == "tutorial":
        return "tutorial"
    ended = episode.outcome in FINISHED or header.source == "import"  # official files do not say how they ended
    if not (episode.complete and ended and episode.ticks):
        return "unfinished"
    poses = np.array([state.robot_poses for state in episode.states])
    path = poses[..., :2].reshape(len(poses), 4)
    return PathEpisode(
        map=header.map,
        place=place,
        source=header.source,
        seats=header.seats,
        path=path,
        file=os.path.realpath(file),
        simulated=header.simulated,
        content=content(episode) if content else None,
    )


# ---- populations -------------------------------------------------------------------------------------------

Populations = dict[str, list[PathEpisode]]


def _of_group(episode: PathEpisode) -> tuple[str, ...]:
    return ("+".join(episode.people),) if episode.people else ()


def _of_kind(episode: PathEpisode) -> tuple[str, ...]:
    return ("+".join(sorted({seat.kind for seat in episode.seats})),)


def _of_agent(episode: PathEpisode) -> tuple[str, ...]:
    names = {player_label(seat.kind, seat.name, episode.simulated) for seat in episode.seats}
    return ("+".join(sorted(names)),)


GROUPINGS: dict[str, Callable[[PathEpisode], tuple[str, ...]]] = {
    "place": lambda episode: (episode.place,),
    "group": _of_group,
    "participant": lambda episode: episode.people,
    "agent": _of_agent,
    "kind": _of_kind,
    "source": lambda episode: (episode.source,),
}
"""The populations of an episode: the file or folder it was named by; those who played it together; each of them; the
agents, with all people as one; human or agent; where it comes from (live, match, scripted, import)."""

STYLE = "style"  # one more: all who play in one style, and those of two styles who played together


def populations(episodes: Iterable[PathEpisode], by: str, styles: Styles | None = None) -> Populations:
    """The episodes of each population; all together as one more where there are several.

    Raises RecordingError when nobody is named in any of them, and by style for people without one.
    """
    found: defaultdict[str, list[PathEpisode]] = defaultdict(list)
    everything = list(episodes)
    names_of = _by_style(everything, styles or {}) if by == STYLE else GROUPINGS[by]
    for episode in everything:
        for name in names_of(episode):
            found[name].append(episode)
    if everything and not found:
        raise RecordingError(f"no recording names its participants, so --by {by} is impossible; try --by source")
    named = {name: found[name] for name in sorted(found)}
    if len(named) == 1:
        return named
    return {**named, ALL: list({episode.file: episode for episode in everything}.values())}


def unnamed(episodes: Iterable[PathEpisode], groups: Populations) -> list[PathEpisode]:
    """Those that are in no population but all together: they name nobody."""
    named = {id(episode) for name, group in groups.items() if name != ALL for episode in group}
    return [episode for episode in episodes if id(episode) not in named]


def _by_style(episodes: Sequence[PathEpisode], styles: Styles) -> Callable[[PathEpisode], tuple[str, ...]]:
    of_people = styles_of((name for episode in episodes for name in episode.people), styles)
    return lambda episode: (style_of_pair(episode.people, of_people),) if episode.people else ()


def with_maps_apart(episodes: Sequence[PathEpisode]) -> tuple[list[PathEpisode], list[str]]:
    """The same; where different maps of one's own have one name, they are called NAME.1, NAME.2, …, which is told."""
    numbers, several = numbered_maps((one.map, Path(one.file).name) for one in episodes)
    found = [replace(one, map=numbered_map(one.map, number)) for one, number in zip(episodes, numbers, strict=True)]
    return found, [one_name_sentence(name, firsts) for name, firsts in several.items()]


def by_map(episodes: Iterable[PathEpisode]) -> Iterator[tuple[MapSpec, list[PathEpisode]]]:
    """The episodes of each map: the paper's twelve in their order, then others by name."""
    found: defaultdict[str, list[PathEpisode]] = defaultdict(list)
    for episode in episodes:
        found[episode.map.name].append(episode)
    firsts = sorted((group[0].map for group in found.values()), key=lambda one: (one.number == 0, one.number, one.name))
    yield from ((one, found[one.name]) for one in firsts)
