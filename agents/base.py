"""The contract of an agent: it turns an observation into the next actions."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
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
    """Chooses actions for one seat. One instance plays one seat of one episode at a time."""

    def reset(self, episode: EpisodeInfo) -> None: ...

    def act(self, observation: Observation) -> ActionChunk: ...


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
