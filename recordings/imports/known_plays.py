"""What a folder has recorded already: a trajectory that was exported from one of its recordings is no second play."""

import hashlib
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.progress import map_in_processes
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_players
from movingout.world.state import Floats

KnownPlays = Mapping[str, Path]
"""Recordings by the digest of what was played in them."""


def play_digest(map_name: str, actions: Floats, robot_poses: Floats, item_poses: Floats) -> str:
    """The same for the same play: its actions (T, 2, 3) and the poses (2, 3) and (N, 3) before the last of them.

    These are what every official shape holds, in the same floats; a variant of a map shows in the poses.
    """
    pressed = np.concatenate([actions[..., :2], actions[..., 2:] > 0.5], axis=-1)
    numbers = b"".join(np.ascontiguousarray(part, np.float64).tobytes() for part in (pressed, robot_poses, item_poses))
    return hashlib.sha256(map_name.encode() + b"\n" + numbers).hexdigest()


def known_plays(folder: Path, maps: Iterable[str], workers: int = 1) -> KnownPlays:
    """The finished recordings of a folder that were played on one of the maps; damaged ones are passed over."""
    paths = sorted(path for path in folder.glob(f"*{SUFFIX}") if path.is_file())
    digests = map_in_processes(partial(_digest, maps=frozenset(maps)), paths, workers, "comparing with what is there")
    return {digest: path for path, digest in zip(paths, digests, strict=True) if digest}


def _digest(path: Path, maps: frozenset[str]) -> str:
    """The digest of a recording, empty for one on another map and for one that cannot be read."""
    try:
        if read_players(path).map not in maps:
            return ""
        episode = read_episode(path)
    except RecordingError:
        return ""
    if not episode.ticks:
        return ""
    last = episode.states[-2]
    return play_digest(episode.header.map.name, episode.actions, last.robot_poses, last.item_poses)
