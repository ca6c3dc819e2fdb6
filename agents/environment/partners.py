"""The partners that an environment draws from, one for each episode."""

from collections.abc import Sequence

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import Agent, EpisodeInfo
from movingout.agents.catalogue import agent_card, load_agent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.agents.scripted.populations import PEOPLE, POPULATIONS
from movingout.maps.suggestion import known_names
from movingout.world.state import Floats, WorldState

_PEOPLE = "people:"


def partner_groups(partner: str | Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The agent ids that each name means; `people:A` stands for the twenty scripted people of population A.

    Raises AgentError for an id that is not known, and when there is none.
    """
    named = [partner] if isinstance(partner, str) else list(partner)
    groups = tuple(_ids(str(name)) for name in named)
    if not groups:
        raise AgentError('a partner is needed: "scripted", "idle", or a list of agents to draw from')
    for group in groups:
        for agent_id in group:
            agent_card(agent_id)
    return groups


def _ids(name: str) -> tuple[str, ...]:
    if not name.startswith(_PEOPLE):
        return (name,)
    population = name.removeprefix(_PEOPLE)
    if population not in POPULATIONS:
        raise AgentError(f"unknown population {population!r}; {known_names(population, POPULATIONS)}")
    return tuple(f"person:name={population}{number:02d}" for number in range(1, PEOPLE + 1))


class PartnerSeat:
    """An agent that plays one seat of one episode at a time; it is asked when its last chunk is used up."""

    def __init__(self, agent_id: str) -> None:
        """Raises AgentError when the agent cannot be made."""
        self.agent_id = agent_id
        self._agent: Agent = load_agent(agent_id)
        self._rows: list[Floats] = []

    def reset(self, episode: EpisodeInfo) -> None:
        """Start an episode."""
        self._episode = episode
        self._rows = []
        self._agent.reset(episode)

    def action(self, state: WorldState) -> Floats:
        """The action (4,) of the coming tick. Raises AgentError for an answer that is no chunk of actions."""
        if not self._rows:
            chunk = checked_chunk(self._agent.act(observe(self._episode.map, state, self._episode.seat)))
            self._rows = list(np.array(chunk[: rows_to_execute(self._agent, chunk)]))
        return self._rows.pop(0)
