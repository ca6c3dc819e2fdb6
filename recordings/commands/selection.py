"""Which recordings in a folder are counted: each episode once, and none that its study does not count."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.study_rounds import counted_recordings


class Selection(NamedTuple):
    """The recordings that count, and how many others there are."""

    paths: list[Path]
    uncounted: int = 0  # which their study leaves out
    copies: int = 0  # of recordings that are there, too


def selected(paths: Sequence[Path]) -> Selection:
    """Those that count. Raises RecordingError for a database of a study that cannot be read."""
    kept = counted_recordings(paths)
    once = without_copies(kept)
    return Selection(once, len(paths) - len(kept), len(kept) - len(once))


def left_out_words(uncounted: int, copies: int) -> list[str]:
    """`2 not counted by their study`, `1 copy`."""
    words = [f"{uncounted} not counted by their study"] if uncounted else []
    return words + ([f"{copies} {'copy' if copies == 1 else 'copies'}"] if copies else [])
