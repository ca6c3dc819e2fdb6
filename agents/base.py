"""The contract of an agent: it turns an observation into the next actions."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.world import World
from movingout.world.observation.description import Description
from movingout.world.ping import HelpPing
from movingout.world.state import WorldState

THREADS = 1  # per agent: the other cores run rooms and other agents

ActionChunk = npt.NDArray[np.float64]
"""(H, 4) with H >= 1: distance in [-1, 1], cos, sin of the heading, grasp toggle {0, 1}; row 0 is the coming tick."""


@dataclass(frozen=True, slots=True)
class EpisodeInfo:
    """What an agent is told when an episode starts."""

    map: MapSpec
    seat: int  # 0 blue, 1 red
    seed: int
    ticks: int  # the limit


def _indescribable() -> Description:
    raise NotImplementedError("this observation was made without a map")


@dataclass(frozen=True, slots=True)
class Observation:
    """What an agent sees before a tick.

    `encode` gives the egocentric vector (D,) of a named layout (`world.observation`), `describe` the state in words and
    as JSON (`world.observation.description`). Pings are no part of any layout:
    an agent that answers them looks at `pings`.
    """

    state: WorldState
    tick: int
    seat: int
    encode: Callable[[str], npt.NDArray[np.float64]]
    pings: tuple[HelpPing, ...] = ()  # of both seats, shown now; oldest first
    describe: Callable[[], Description] = field(default=_indescribable, compare=False, repr=False)


class Agent(Protocol):
    """Chooses actions for one seat. One instance plays one seat of one episode at a time.

    What it may have besides:
    `execute_rows`: how many rows of a chunk are played before it is asked again; all, where it is missing.
    `detail`: a mapping with the trace of the decision that was made just now.
    `deterministic`: False for one that does not answer the same each time.
    `waits`: True for one whose decisions wait for somebody else; no room seats it.
    `episode_counts`: a mapping of names to whole numbers, counted in the episode; results of matches keep them.
    `not_played`: after an episode in which only a fallback played for it, the sentence with which its match fails.
    `watch(world)`: is called after `reset`, for an oracle.
    `agent`: the agent inside, of one that is put around another (`Wrapper`).
    `batch_key`, `act_many`: of a `BatchAgent`.
    """

    def reset(self, episode: EpisodeInfo) -> None: ...

    def act(self, observation: Observation) -> ActionChunk: ...


@runtime_checkable
class Watcher(Protocol):
    """An agent with access to the world it plays in: an oracle, for experiments."""

    def watch(self, world: World) -> None: ...


class Wrapper:
    """What is put around another agent has what that one has besides `reset` and `act`, but for `execute_rows`."""

    def __init__(self, agent: Agent) -> None:
        self.agent = agent

    @property
    def detail(self) -> object:
        """The trace of the decision that was made just now."""
        return getattr(self.agent, "detail", {})

    @property
    def deterministic(self) -> bool:
        """Whether the agent inside answers the same each time."""
        return bool(getattr(self.agent, "deterministic", True))

    @property
    def waits(self) -> bool:
        """Whether the decisions of the agent inside wait for somebody else."""
        return bool(getattr(self.agent, "waits", False))

    @property
    def episode_counts(self) -> object:
        """What the agent inside counted in the episode."""
        return getattr(self.agent, "episode_counts", {})

    @property
    def not_played(self) -> object:
        """Why the episode was not the agent's inside."""
        return getattr(self.agent, "not_played", "")

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self.agent.reset(episode)

    def watch(self, world: World) -> None:
        """Give an oracle access to the world."""
        if isinstance(self.agent, Watcher):
            self.agent.watch(world)


@runtime_checkable
class BatchAgent(Protocol):
    """Optional extension of `Agent`: decides for many episodes in one call, for matches that run side by side.

    Agents of one class with equal `batch_key` are asked together. Each answer must be the one that `act` would give,
    to the bit: a match gives the same numbers whatever is played beside it.
    """

    @property
    def batch_key(self) -> Hashable: ...

    @staticmethod
    def act_many(agents: Sequence[Any], observations: Sequence[Observation]) -> Sequence[ActionChunk]: ...


def batch_group(agent: Agent) -> Hashable:
    """What the agents have in common that are asked together; None for one that decides alone.

    Raises AgentError for a key that cannot be hashed, and whatever `batch_key` raises.
    """
    if not isinstance(agent, BatchAgent):
        return None
    group = type(agent), agent.batch_key
    try:
        hash(group)
    except TypeError as error:
        raise AgentError(
            f"batch_key is no value that can be hashed ({error}); give a text, a number or a tuple"
        ) from error
    return group
