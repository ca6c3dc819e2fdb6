"""What to export: which recordings, where to, with which options."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

from movingout.maps.files.map_versions import numbered_map, numbered_maps, one_name_sentence
from movingout.maps.library import is_reserved
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.alike import with_shared_ids
from movingout.recordings.exports.split import TRAIN, SplitBy, split
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.progress import with_progress
from movingout.recordings.ray_cluster import map_on_ray
from movingout.recordings.storage.listing import Players, read_map, read_players
from movingout.world.observation import LAYOUTS

Worked = TypeVar("Worked")


def _warn(sentence: str) -> None:
    warnings.warn(sentence, RuntimeWarning, stacklevel=3)


class Planned(NamedTuple):
    """One recording of a plan."""

    path: Path
    part: str  # of the split
    number: str  # of its map, "" where no other has its name


@dataclass(frozen=True)
class ExportPlan:
    """The options of all formats; each format uses those that apply to it."""

    recordings: Sequence[Path]
    target: Path
    test_share: float = 0.0  # of the episodes
    seed: int = 0  # of the split
    split_by: SplitBy = "participant"  # what is never divided
    layout: str = "official-v1"  # of observations (world/observation/layouts.py)
    view: str = "ego"  # ego: two episodes, one per seat; joint: one episode with both actions
    images: int = 0  # pixels of a side of what a seat sees, as video beside the numbers; 0 for none
    side: int = 512  # pixels
    speed: float = 1.0  # of videos, times real time
    every_s: float = 5.0  # seconds between the pictures of a strip
    overlay: bool = True  # names, time and deliveries on pictures
    tell: Callable[[str], None] = _warn  # takes a sentence on what was written, for whoever goes on with it
    ray: str = ""  # address of a Ray cluster that reads and converts the episodes; empty for this process

    def episodes(self, verb: str, training_first: bool = False) -> Iterator[tuple[Episode, str]]:
        """The episodes with their split, one at a time, with a progress bar."""
        planned = self._planned(training_first)
        for one in with_progress(planned, len(planned), verb):
            yield read_episode(one.path), one.part

    def converted(
        self, convert: Callable[[Episode, str], Worked], verb: str, training_first: bool = False
    ) -> Iterator[Worked]:
        """What `convert` makes of each episode and its split, in order, here or on the cluster. Raises NoCluster.

        Different maps of one name are called NAME.1, NAME.2, … in these episodes, which is told.
        """

        def convert_one(one: Planned) -> Worked:
            return convert(_with_number(read_episode(one.path), one.number), one.part)

        for sentence in self.one_name_sentences:
            self.tell(sentence)
        planned = self._planned(training_first)
        if not self.ray:
            yield from map(convert_one, with_progress(planned, len(planned), verb))
            return
        away = [one._replace(path=one.path.resolve()) for one in planned]
        yield from map_on_ray(self.ray, convert_one, away, verb)

    def _planned(self, training_first: bool) -> list[Planned]:
        planned = list(map(Planned, self.recordings, self.splits, self._numbers[0]))
        return sorted(planned, key=lambda one: one.part != TRAIN) if training_first else planned

    def check_seen(self) -> None:
        """Raises RecordingError for recordings on maps with more of something than the layout has room for."""
        layout = LAYOUTS.get(self.layout)
        readable = zip(self.recordings, self.players, strict=True)
        if layout and (why := layout.refusal((path, read_map(path)) for path, _ in readable)):
            raise RecordingError(why)

    @cached_property
    def splits(self) -> list[str]:
        """`train` or `test` per recording. Split by episode, those that are equal action by action are not divided."""
        players = self.players
        if self.test_share and self.split_by == "episode":
            players = with_shared_ids(self.recordings, players)
        return split(players, self.test_share, self.seed, self.split_by)

    @property
    def map_names(self) -> list[str]:
        """The name of each recording's map, with its number where different maps have that name."""
        pairs = zip(self.players, self._numbers[0], strict=True)
        return [f"{one.map}.{number}" if number else one.map for one, number in pairs]

    @property
    def one_name_sentences(self) -> list[str]:
        """What each map is that got a number."""
        return [one_name_sentence(name, firsts) for name, firsts in self._numbers[1].items()]

    @cached_property
    def _numbers(self) -> tuple[list[str], dict[str, list[str]]]:
        """See `numbered_maps`. Maps that are known by name need not be read."""
        own = [index for index, one in enumerate(self.players) if not is_reserved(one.map)]
        paths = [self.recordings[index] for index in own]
        found, several = numbered_maps((read_map(path), path.name) for path in paths)
        numbers = dict(zip(own, found, strict=True))
        return [numbers.get(index, "") for index in range(len(self.recordings))], several

    @cached_property
    def players(self) -> list[Players]:
        """Who played, per recording. RecordingError when one cannot be read, or when two are the same episode."""
        found: dict[str, Path] = {}
        players = []
        for path in self.recordings:
            try:
                players.append(read_players(path))
            except RecordingError as error:
                raise RecordingError(f"{error}; leave it out to export the others") from error
            episode_id = players[-1].episode_id
            if episode_id in found:
                raise RecordingError(
                    f"{found[episode_id].name} and {path.name} are the same episode, {episode_id}; leave one out"
                )
            found[episode_id] = path
        return players


def _with_number(episode: Episode, number: str) -> Episode:
    """The episode on a map whose name has a number."""
    header = episode.header
    return replace(episode, header=replace(header, map=numbered_map(header.map, number))) if number else episode
