"""What to export: which recordings, where to, with which options."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

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
        pairs = self._pairs(training_first)
        for path, part in with_progress(pairs, len(pairs), verb):
            yield read_episode(path), part

    def converted(
        self, convert: Callable[[Episode, str], Worked], verb: str, training_first: bool = False
    ) -> Iterator[Worked]:
        """What `convert` makes of each episode and its split, in order, here or on the cluster. Raises NoCluster."""
        if not self.ray:
            yield from (convert(episode, part) for episode, part in self.episodes(verb, training_first))
            return

        def convert_one(pair: tuple[Path, str]) -> Worked:
            return convert(read_episode(pair[0]), pair[1])

        pairs = [(path.resolve(), part) for path, part in self._pairs(training_first)]
        yield from map_on_ray(self.ray, convert_one, pairs, verb)

    def _pairs(self, training_first: bool) -> list[tuple[Path, str]]:
        pairs = list(zip(self.recordings, self.splits, strict=True))
        return sorted(pairs, key=lambda pair: pair[1] != TRAIN) if training_first else pairs

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
