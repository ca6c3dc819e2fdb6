"""A seat of a match: asks its agent when its chunk is used up, and hands out one row per tick."""

from collections.abc import Hashable
from types import TracebackType

from movingout.agents.action_chunk import rows_to_execute
from movingout.agents.base import Agent, BatchAgent, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.maps.spec import SEAT_COLOURS
from movingout.matches.execution.decision_timeout import Stopwatch, TooLate
from movingout.world.state import Floats, WorldState

WorldAction = list[float]  # distance, heading [rad], toggle


class AgentFault(Exception):
    """An agent did something that loses its match."""

    def __init__(self, seat: int, reason: str) -> None:
        super().__init__(reason)
        self.seat = seat
        self.reason = reason


class Seat:
    """An agent in a seat."""

    def __init__(self, agent: Agent, agent_id: str, episode: EpisodeInfo, state: WorldState) -> None:
        self.agent = agent
        self.agent_id = agent_id
        self.episode = episode
        self.state = state  # the world before the coming tick
        self.rows: list[WorldAction] = []  # still to be played
        self.fault: AgentFault | None = None
        # Who is asked together with it, None for nobody; here once, since to see what an agent can takes its time.
        self.group: Hashable = (type(agent), agent.batch_key) if isinstance(agent, BatchAgent) else None

    def observation(self) -> Observation:
        return observe(self.episode.map, self.state, self.episode.seat)

    def take(self, chunk: Floats, rows: list[WorldAction]) -> None:
        """Keep the part of an answer that is to be played; `rows` is the chunk (H, 4) as world actions."""
        self.rows = rows[: rows_to_execute(self.agent, chunk)]

    def next_action(self) -> WorldAction:
        return self.rows.pop(0)

    def lose(self, reason: str) -> None:
        """Note what the agent did wrong; the first fault stands."""
        self.fault = self.fault or AgentFault(self.episode.seat, reason)


class Blaming:
    """Turns whatever an agent's code raises in the block into an AgentFault of its seat."""

    def __init__(self, seat: int, agent_id: str, stopwatch: Stopwatch, call: str) -> None:
        self._seat, self._agent_id, self._stopwatch, self._call = seat, agent_id, stopwatch, call

    def __enter__(self) -> None:
        self._stopwatch.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stopwatch.stop()
        if isinstance(error, TooLate | Exception | SystemExit):
            reason = sentence(self._seat, self._agent_id, self._call, error, self._stopwatch.limit_s)
            raise AgentFault(self._seat, reason) from error


def sentence(seat: int, agent_id: str, call: str, error: BaseException, limit_s: float) -> str:
    """What an agent did wrong, for people."""
    who = f"{SEAT_COLOURS[seat]} ({agent_id})"
    if isinstance(error, TooLate):
        text = f"{who} did not answer {call} within {limit_s:g} s"
    elif isinstance(error, AgentError):
        text = f"{who}, {call}: {error}"
    else:
        text = f"{who} raised {type(error).__name__} in {call}: {error}"
    return text[:500]
