"""A seat in a match: one agent, and the rows of its last action chunk that are still to be played."""

from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Integral

from movingout.agents.base import Agent, EpisodeInfo, Observation, batch_group
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import fault_place, located, writable
from movingout.agents.observation.seat_observation import observe
from movingout.maps import MovingOutError
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c
from movingout.maps.spec import SEAT_COLOURS
from movingout.matches.execution.decision_timeout import DecisionTimeout, DecisionTimer
from movingout.world.state import WorldState

WorldAction = list[float]  # distance, heading [rad], toggle


class AgentFault(Exception):
    """Something an agent did that makes its match fail."""

    def __init__(self, seat: int, reason: str) -> None:
        super().__init__(reason)
        self.seat = seat
        self.reason = reason


class MatchSeat:
    """An agent in a seat of one match."""

    def __init__(self, agent: Agent, agent_id: str, episode: EpisodeInfo, state: WorldState) -> None:
        self.agent = agent
        self.agent_id = agent_id
        self.episode = episode
        self.state = state  # the world before the coming tick
        self.rows: list[WorldAction] = []  # still to be played
        self.fault: AgentFault | None = None
        self.failed_together = False  # in one call with other seats, any of which may be at fault
        # Agents of one group decide in one batch; None decides alone. Determined once, as the check is slow.
        self.group: Hashable = batch_group(agent)

    def observation(self) -> Observation:
        """What the agent sees now. Its arrays are its own: the metrics and the other seat see what was played."""
        return observe(self.episode.map, self.state.copy(), self.episode.seat)

    def account(self) -> dict[str, int]:
        """What the agent counted in the match, as `red_llm_questions`. Raises AgentError where it did not play it."""
        reason, found = getattr(self.agent, "not_played", ""), getattr(self.agent, "episode_counts", {})
        if isinstance(reason, str) and reason:
            raise AgentError(reason)
        counts = found.items() if isinstance(found, Mapping) else ()
        colour = SEAT_COLOURS[self.episode.seat]
        return {f"{colour}_{name}": int(count) for name, count in counts if isinstance(count, Integral)}

    def next_action(self) -> WorldAction:
        return self.rows.pop(0)

    def lose(self, reason: str, together: bool = False) -> None:
        """Note what the agent did wrong, maybe `together` with others; only the first fault counts."""
        self.fault = self.fault or AgentFault(self.episode.seat, reason)
        self.failed_together |= together


@contextmanager
def attribute_agent_errors(
    seat: int, agent_id: str, timer: DecisionTimer, call: str, at_least_s: float = 0.0
) -> Iterator[None]:
    """Time the block, and turn whatever an agent's code raises in it into an AgentFault of its seat.

    The block may take the timer's limit, or `at_least_s` if that is longer.
    """
    timer.start(at_least_s)
    try:
        yield
    except (DecisionTimeout, *FOREIGN_CODE_RAISES) as error:
        if is_ctrl_c(error):
            raise
        raise AgentFault(seat, fault_sentence(seat, agent_id, call, error, max(timer.limit_s, at_least_s))) from error
    finally:
        timer.stop()


def fault_sentence(seat: int, agent_id: str, call: str, error: BaseException, limit_s: float) -> str:
    """What an agent did wrong, for a person to read."""
    who = f"{SEAT_COLOURS[seat]} ({agent_id})"
    if isinstance(error, DecisionTimeout):
        return located(f"{who} did not answer {call} within {limit_s:g} s", error)
    if isinstance(error, MovingOutError) and (isinstance(error, AgentError) or not fault_place(error)):
        return writable(f"{who}, {call}: {error}")[:500]
    return located(f"{who} raised {type(error).__name__} in {call}: {error}", error)
