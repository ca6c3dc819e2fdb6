"""Episodes that are equal action by action, as two plays of agents in which nothing is drawn."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.play_hash import play_hash
from movingout.recordings.storage.listing import Players, read_summary


def with_shared_ids(recordings: Sequence[Path], players: Sequence[Players]) -> list[Players]:
    """The same players; of episodes that are equal, all have the first id. Raises RecordingError.

    Only those that may be equal are read whole.
    """
    similar: dict[object, list[int]] = defaultdict(list)
    for index, path in enumerate(recordings):
        summary = read_summary(path)
        similar[summary.map, summary.variant, summary.ticks, tuple(summary.metrics.items())].append(index)
    shared = list(players)
    for indices in similar.values():
        for alike in _equal(recordings, indices) if len(indices) > 1 else ():
            first = min(players[index].episode_id for index in alike)
            for index in alike:
                shared[index] = players[index]._replace(episode_id=first)
    return shared


def _equal(recordings: Sequence[Path], indices: Sequence[int]) -> list[list[int]]:
    """These, put together where they are equal."""
    found: dict[str, list[int]] = defaultdict(list)
    for index in indices:
        found[play_hash(read_episode(recordings[index]))].append(index)
    return list(found.values())
