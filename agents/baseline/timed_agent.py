"""An agent whose decisions are timed, for `agents probe` and `doctor`."""

import time

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, Observation, Wrapper


class TimedAgent(Wrapper):
    """An agent with timed decisions: one entry per call in `decisions_ms`."""

    def __init__(self, agent: Agent) -> None:
        super().__init__(agent)
        self.decisions_ms: list[float] = []

    def act(self, observation: Observation) -> ActionChunk:
        """What the agent answers, to be played as it says (h, 4). Raises AgentError for an invalid answer."""
        began = time.perf_counter()
        answer = self.agent.act(observation)
        self.decisions_ms.append((time.perf_counter() - began) * 1e3)
        chunk = checked_chunk(answer)
        return chunk[: rows_to_execute(self.agent, chunk)]
