"""Delayed play: at tick t, the action decided at t - lag (paper, "Inference Speed of DP/BASS": lag 1).

The paper's agents hide their decision time that way. Ours decide within the tick; the option `lag` of any agent
(`bass@all:lag=1`) reproduces the paper's condition.
"""

from collections import deque

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Observation
from movingout.agents.data.rollout import Watcher
from movingout.agents.errors import AgentError
from movingout.world import World
from movingout.world.state import Floats

MAX_LAG = 10  # [ticks]
_REST = np.array([0.0, 1.0, 0.0, 0.0])


class DelayedAgent:
    """Plays any agent `lag` ticks late; stands still until the first action is due."""

    execute_rows = 1

    def __init__(self, agent: Agent, lag: int) -> None:
        """Raises AgentError unless `lag` is a whole number of ticks from 1 to MAX_LAG."""
        if type(lag) is not int or not 1 <= lag <= MAX_LAG:
            raise AgentError(f"lag is a whole number of ticks from 1 to {MAX_LAG}, not {lag!r}")
        self.agent = agent
        self.lag = lag

    @property
    def detail(self) -> object:
        """The trace of the decision that was made just now and is played later."""
        return getattr(self.agent, "detail", {})

    @property
    def deterministic(self) -> bool:
        """Whether the agent inside answers the same each time."""
        return bool(getattr(self.agent, "deterministic", True))

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._planned: deque[Floats] = deque()
        self._due: deque[Floats] = deque([_REST] * self.lag)
        self.agent.reset(episode)

    def watch(self, world: World) -> None:
        """Give an oracle access to the world."""
        if isinstance(self.agent, Watcher):
            self.agent.watch(world)

    def act(self, observation: Observation) -> ActionChunk:
        """One row (1, 4): the one decided `lag` ticks ago."""
        if not self._planned:
            chunk = checked_chunk(self.agent.act(observation))
            self._planned.extend(chunk[: rows_to_execute(self.agent, chunk)])
        self._due.append(self._planned.popleft())
        return self._due.popleft()[None].copy()
