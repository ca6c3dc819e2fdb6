"""What is asked of an export: which recordings, where to, and with which options."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from recordings.episode import Episode
from recordings.exports.split import split
from recordings.listing import read_players
from recordings.progress import track
from recordings.reader import read_episode


@dataclass(frozen=True)
class Plan:
    """The options of every format; each uses those that mean something to it."""

    recordings: Sequence[Path]
    target: Path
    test_share: float = 0.0  # of the episodes, by participants
    seed: int = 0  # of the split
    layout: str = "official-v1"  # of observations (world/observation.py)
    view: str = "ego"  # ego: two episodes, one per seat; joint: one episode with both actions
    side: int = 512  # pixels
    speed: float = 1.0  # of videos, times real time
    every_s: float = 5.0  # seconds between the pictures of a strip
    overlay: bool = True  # names, time and deliveries on pictures

    def episodes(self, verb: str) -> Iterator[tuple[Episode, str]]:
        """Each episode with its split, one after the other, with a bar on a terminal."""
        for path, part in track(zip(self.recordings, self.splits, strict=True), len(self.recordings), verb):
            yield read_episode(path), part

    @cached_property
    def splits(self) -> list[str]:
        """`train` or `test` per recording."""
        return split([read_players(path) for path in self.recordings], self.test_share, self.seed)
