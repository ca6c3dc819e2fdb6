"""The partners that an environment draws from, one for each episode."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import Agent, EpisodeInfo, Watcher
from movingout.agents.catalogue import agent_card, check_options_once, load_agent
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.agents.observation.seat_observation import observe
from movingout.agents.partners.families import group, is_own
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.world import World
from movingout.world.state import Floats, WorldState


def partner_groups(partner: str | Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The agent ids that each name means; `people:A` and `family:greedy` stand for several.

    All such names are in `agents.partners.families`.

    Raises AgentError for an id that is not known or has an option twice, and when there is none.
    """
    named = [partner] if isinstance(partner, str) or not isinstance(partner, Iterable) else list(partner)
    if wrong := [name for name in named if not isinstance(name, str)]:
        raise AgentError(f'a partner is the id of an agent, such as "scripted", or a list of ids, not {wrong[0]!r:.80}')
    groups = tuple(tuple(one.agent_id for one in group(name)) for name in named)
    if not groups:
        raise AgentError('a partner is needed: "scripted", "idle", or a list of agents to draw from')
    for name, ids in zip(named, groups, strict=True):
        for agent_id in ids:
            check_options_once(agent_id)
            (load_agent if is_own(name) else agent_card)(agent_id)
    return groups


class PartnerSeat:
    """An agent that plays one seat of one episode at a time; it is asked when its last chunk is used up."""

    def __init__(self, agent_id: str) -> None:
        """Raises AgentError when the agent cannot be made."""
        self.agent_id = agent_id
        self._agent: Agent = load_agent(agent_id)
        self._rows: list[Floats] = []

    def reset(self, episode: EpisodeInfo, world: World) -> None:
        """Start an episode in `world`, which an oracle is given. Raises AgentError for what the agent raises."""
        self._episode = episode
        self._rows = []
        with self._named("reset()"):
            self._agent.reset(episode)
        if isinstance(self._agent, Watcher):
            with self._named("watch()"):
                self._agent.watch(world)

    def action(self, state: WorldState) -> Floats:
        """The action (4,) of the coming tick. Raises AgentError for what the agent raises, and for a wrong answer."""
        if not self._rows:
            with self._named("act()"):
                chunk = checked_chunk(self._agent.act(observe(self._episode.map, state.copy(), self._episode.seat)))
                self._rows = list(np.array(chunk[: rows_to_execute(self._agent, chunk)]))
        return self._rows.pop(0)

    @contextmanager
    def _named(self, call: str) -> Iterator[None]:
        """Errors in this block become AgentErrors that name the agent."""
        who = f"the partner {self.agent_id}"
        with noticing_ctrl_c():
            try:
                yield
            except AgentError as error:
                raise AgentError(f"{who}: {error}") from error
            except FOREIGN_CODE_RAISES as error:
                if is_ctrl_c(error):
                    raise
                raise AgentError(located(f"{who} raised {type(error).__name__} in {call}: {error}", error)) from error
