"""Episodes side by side on one timeline."""

from collections.abc import Sequence

import viser

from movingout.maps.spec import ARENA_HALF
from movingout.recordings.episode import Episode
from movingout.recordings.viewer.episode_scene import EpisodeScene, Layers

_GAP = 0.3  # arena units between two arenas


def row_width(count: int) -> float:
    """How wide `count` arenas side by side are."""
    return count * 2 * ARENA_HALF + (count - 1) * _GAP


class SideBySide:
    """The scenes of one or two episodes, centred on the origin; the longest sets the length."""

    def __init__(self, scene: viser.SceneApi, episodes: Sequence[Episode]) -> None:
        first = -row_width(len(episodes)) / 2 + ARENA_HALF
        pitch = 2 * ARENA_HALF + _GAP
        self.scenes = [
            EpisodeScene(scene, f"episode{place}", episode, first + place * pitch)
            for place, episode in enumerate(episodes)
        ]

    @property
    def last(self) -> int:
        return max(one.last for one in self.scenes)

    def show(self, tick: int, layers: Layers) -> None:
        for one in self.scenes:
            one.show(tick, layers)

    def remove(self) -> None:
        for one in self.scenes:
            one.remove()
