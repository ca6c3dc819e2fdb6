"""An agent whose decisions are timed, for `agents probe` and `doctor`."""

import time

from movingout.agents.action_chunk import rows_to_execute
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Observation


class TimedAgent:
    """An agent with timed decisions: one entry per call in `decisions_ms`."""

    def __init__(self, agent: Agent) -> None:
        self.agent = agent
        self.decisions_ms: list[float] = []

    def reset(self, episode: EpisodeInfo) -> None:
        self.agent.reset(episode)

    def act(self, observation: Observation) -> ActionChunk:
        began = time.perf_counter()
        chunk = self.agent.act(observation)
        self.decisions_ms.append((time.perf_counter() - began) * 1e3)
        return chunk[: rows_to_execute(self.agent, chunk)]
