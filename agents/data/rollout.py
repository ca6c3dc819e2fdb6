"""Two agents in one world without clock or network, for demonstrations and training."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute, world_action
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Watcher
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.maps import MapSpec
from movingout.world import World
from movingout.world.state import Floats, WorldState


@dataclass(frozen=True, slots=True, eq=False)
class RolloutStep:
    """One tick: the state before, the world actions (2, 3), the state after."""

    before: WorldState
    actions: Floats
    after: WorldState


class SeatPlayer:
    """An agent in a seat: plays the rows of its chunk, then asks for the next."""

    def __init__(self, agent: Agent, episode: EpisodeInfo) -> None:
        self.agent = agent
        self.episode = episode
        self._rows: list[Floats] = []
        agent.reset(episode)

    def action(self, state: WorldState) -> tuple[float, float, float]:
        """The world action for the coming tick. Raises AgentError for an invalid chunk."""
        if not self._rows:
            observation = observe(self.episode.map, state.copy(), self.episode.seat)
            chunk: ActionChunk = checked_chunk(self.agent.act(observation))
            self._rows = list(chunk[: rows_to_execute(self.agent, chunk)])
        return world_action(self._rows.pop(0))

    def decide_anew(self) -> None:
        """Drop the rest of the chunk: somebody else has acted in this seat since it was decided."""
        self._rows.clear()


def check_undelivered(the_map: MapSpec) -> None:
    """Raises AgentError for a map on which an episode has no tick."""
    if World(the_map, record_sub_poses=False).delivered().all():
        raise AgentError(
            f"on {the_map.name} all items lie in a goal from the start, so there is nothing to play; move one out"
        )


def rollout(the_map: MapSpec, agents: tuple[Agent, Agent], seed: int, ticks: int) -> Iterator[RolloutStep]:
    """Play until everything is delivered, at most `ticks` ticks."""
    world = World(the_map, record_sub_poses=False)
    players = [SeatPlayer(agent, EpisodeInfo(the_map, seat, seed, ticks)) for seat, agent in enumerate(agents)]
    for agent in agents:
        if isinstance(agent, Watcher):
            agent.watch(world)
    before = world.state()
    while world.tick < ticks and not world.delivered().all():
        actions = np.array([player.action(before) for player in players])
        world.step(actions)
        after = world.state()
        yield RolloutStep(before, actions, after)
        before = after
