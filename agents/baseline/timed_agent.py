"""An agent whose decisions are timed, for `agents probe` and `doctor`."""

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, Observation, Wrapper
from movingout.agents.decision_time import unhindered


class TimedAgent(Wrapper):
    """An agent with timed decisions: one entry per call in `decisions_ms`.

    Waiting for a processor that other programs keep busy is no time of the agent's, where the system tells it.
    """

    def __init__(self, agent: Agent) -> None:
        super().__init__(agent)
        self.decisions_ms: list[float] = []

    def act(self, observation: Observation) -> ActionChunk:
        """What the agent answers, to be played as it says (h, 4). Raises AgentError for an invalid answer."""
        began = unhindered()
        answer = self.agent.act(observation)
        self.decisions_ms.append((unhindered() - began) * 1e3)
        chunk = checked_chunk(answer)
        return chunk[: rows_to_execute(self.agent, chunk)]
