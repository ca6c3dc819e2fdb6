"""The partners that an environment draws from, one for each episode."""

from collections.abc import Iterable, Sequence

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import Agent, EpisodeInfo
from movingout.agents.catalogue import agent_card, load_agent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.agents.partners.families import group
from movingout.world.state import Floats, WorldState


def partner_groups(partner: str | Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The agent ids that each name means; `people:A` and `family:greedy` stand for several.

    All such names are in `agents.partners.families`.

    Raises AgentError for an id that is not known, and when there is none.
    """
    named = [partner] if isinstance(partner, str) or not isinstance(partner, Iterable) else list(partner)
    if wrong := [name for name in named if not isinstance(name, str)]:
        raise AgentError(f'a partner is the id of an agent, such as "scripted", or a list of ids, not {wrong[0]!r:.80}')
    groups = tuple(tuple(one.agent_id for one in group(name)) for name in named)
    if not groups:
        raise AgentError('a partner is needed: "scripted", "idle", or a list of agents to draw from')
    for ids in groups:
        for agent_id in ids:
            agent_card(agent_id)
    return groups


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
