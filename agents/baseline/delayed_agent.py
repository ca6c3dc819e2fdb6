"""Delayed play: at tick t, the action decided at t - lag (paper, "Inference Speed of DP/BASS": lag 1).

The paper's agents hide their decision time that way. Ours decide within the tick; the option `lag` of any agent
(`bass@all:lag=1`) reproduces the paper's condition.
"""

from collections import deque

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Observation, Wrapper
from movingout.agents.errors import AgentError
from movingout.world.state import Floats

MAX_LAG = 10  # [ticks]
_REST = np.array([0.0, 1.0, 0.0, 0.0])


class DelayedAgent(Wrapper):
    """Plays any agent `lag` ticks late; stands still until the first action is due."""

    execute_rows = 1

    def __init__(self, agent: Agent, lag: int) -> None:
        """Raises AgentError unless `lag` is a whole number of ticks from 1 to MAX_LAG."""
        if type(lag) is not int or not 1 <= lag <= MAX_LAG:
            raise AgentError(f"lag is a whole number of ticks from 1 to {MAX_LAG}, not {lag!r}")
        super().__init__(agent)
        self.lag = lag

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._planned: deque[Floats] = deque()
        self._due: deque[Floats] = deque([_REST] * self.lag)
        super().reset(episode)

    def act(self, observation: Observation) -> ActionChunk:
        """One row (1, 4): the one decided `lag` ticks ago."""
        if not self._planned:
            chunk = checked_chunk(self.agent.act(observation))
            self._planned.extend(chunk[: rows_to_execute(self.agent, chunk)])
        self._due.append(self._planned.popleft())
        return self._due.popleft()[None].copy()
