"""A hash of what was played: equal for two episodes of which one is the copy of the other, whatever their seeds."""

import hashlib

from movingout.maps import MapSpec
from movingout.recordings.episode import Episode
from movingout.world.state import Floats, WorldState


class PlayHash:
    """Collects the actions of an episode on a map as it was played (Challenge 2 varies it)."""

    def __init__(self, spec: MapSpec) -> None:
        self._hash = hashlib.blake2b(repr(spec).encode(), digest_size=8)

    def update(self, actions: Floats) -> None:
        """Add the world actions (2, 3) of a tick, or (T, 2, 3) of several."""
        self._hash.update(actions.tobytes())

    def of(self, last: WorldState) -> str:
        """16 hexadecimal digits, with the poses in which it ended."""
        whole = self._hash.copy()
        whole.update(last.robot_poses.tobytes() + last.item_poses.tobytes())
        return whole.hexdigest()


def play_hash(episode: Episode) -> str:
    """Of a recording."""
    played = PlayHash(episode.header.map)
    played.update(episode.actions)
    return played.of(episode.states[-1])
