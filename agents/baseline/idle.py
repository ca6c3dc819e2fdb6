"""A partner that does nothing: the control condition in comparisons."""

from collections.abc import Hashable, Sequence

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation

_STILL = np.tile([0.0, 1.0, 0.0, 0.0], (10, 1))  # one second: there is nothing to decide


class IdleAgent:
    """Stands still and never grasps."""

    def reset(self, episode: EpisodeInfo) -> None:
        """Nothing to prepare."""

    def act(self, observation: Observation) -> ActionChunk:
        """Return (10, 4): no motion."""
        return _STILL.copy()

    @property
    def batch_key(self) -> Hashable:
        """All idle agents answer together (`agents.base.BatchAgent`)."""
        return "idle"

    @staticmethod
    def act_many(agents: Sequence["IdleAgent"], observations: Sequence[Observation]) -> list[ActionChunk]:
        """What each would answer."""
        return [_STILL.copy() for _ in agents]
