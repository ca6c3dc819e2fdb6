"""The rounds that a stopped server goes on with: the files of its rooms, data/rooms beside data/recordings, name them.

Their journals are not left behind: a recording made of one ends the round.
"""

import contextlib
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from movingout.recordings.file_format.journal import JOURNAL_SUFFIX


class _Names(msgspec.Struct, frozen=True):
    study: dict[str, str] = {}


class RoundInRoom(msgspec.Struct, frozen=True):
    """What the file of a room says of the round in progress; `episode` is empty where there is none."""

    episode: str = ""
    config: _Names = _Names()

    @property
    def study(self) -> str:
        """The id of its study, empty for a game."""
        return self.config.study.get("study", "")


def rounds_of_rooms(folder: Path, pattern: str = "*.json") -> Iterator[RoundInRoom]:
    """The rounds in progress of the rooms in a folder; files that are not understood have none."""
    for path in folder.glob(pattern):
        with contextlib.suppress(OSError, msgspec.MsgspecError):
            if path.is_file():  # a pipe would never be read to its end
                room = msgspec.json.decode(path.read_bytes(), type=RoundInRoom)
                if room.episode:
                    yield room


def waiting_rounds(journals: Iterable[Path]) -> dict[Path, RoundInRoom]:
    """Those of these journals with which a server goes on."""
    beside: dict[Path, dict[str, RoundInRoom]] = {}
    found = {}
    for journal in journals:
        for data in _data_folders(journal):
            if data not in beside:
                beside[data] = {each.episode: each for each in _rounds_below(data / "rooms")}
            if room := beside[data].get(journal.name.removesuffix(JOURNAL_SUFFIX)):
                found[journal] = room
    return found


def _data_folders(journal: Path) -> set[Path]:
    """Where the folder of recordings is, and where it leads to if it is a link."""
    return {Path(place(journal.parent)).parent for place in (os.path.abspath, os.path.realpath)}


def _rounds_below(rooms: Path) -> Iterator[RoundInRoom]:
    """Those of a cluster lie in a folder per shard."""
    for pattern in ("*.json", "*/*.json"):
        yield from rounds_of_rooms(rooms, pattern)
