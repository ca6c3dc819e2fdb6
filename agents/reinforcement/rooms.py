"""Episodes of a learner with many partners on many maps at once: one batch of decisions for all of them."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from movingout.agents.action_chunk import world_action
from movingout.agents.base import Agent, EpisodeInfo, Watcher
from movingout.agents.bass.value import progress
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.rollout import SeatPlayer
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.agents.inference.policy_agent import agent_rows
from movingout.agents.observation.features import FeatureSet, Singles
from movingout.maps import load_map
from movingout.maps.errors import MovingOutError
from movingout.world import World, WorldError
from movingout.world.action import turned
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats, WorldState


@dataclass(frozen=True, slots=True)
class EpisodeDistribution:
    """Maps and partners, of which every episode is given one of each, drawn evenly."""

    maps: tuple[str, ...]
    partners: tuple[tuple[str, ...], ...]  # groups of agent ids, each group as often as the others
    ticks: int
    load_agent: Callable[[str], Agent]


@dataclass(frozen=True, slots=True, eq=False)
class VectorStep:
    """What came of one decision in each of K rooms."""

    rewards: Floats  # (K,) progress made
    over: Floats  # (K,) 1 where the episode ended, for whatever reason
    delivered: Floats  # (K,) 1 where everything was delivered
    last: tuple[Singles | None, ...]  # what was seen at the end of the episodes that ended (D,)


class RoomDecision(NamedTuple):
    """What came of one decision."""

    gained: float  # progress
    over: bool
    delivered: bool  # everything
    last: Singles | None = None  # where it is over: what was seen at its end, before the next one began


class PlayRoom:
    """One world after another, with the learner in one seat."""

    def __init__(self, distribution: EpisodeDistribution, spec: PolicySpec, seed: int) -> None:
        self._distribution, self._spec = distribution, spec
        self._seen = FeatureSet.of(spec)
        self._random = np.random.default_rng(seed)
        self._past: deque[WorldState] = deque(maxlen=self._seen.memory_ticks + 1)
        self._open()

    def reseed(self, seed: int) -> None:
        """Begin another episode, drawn from another seed."""
        self._random = np.random.default_rng(seed)
        self._open()

    def features(self) -> Singles:
        """What the learner sees (D,)."""
        rows = self._seen.of_moments(self._world.map, [self._past[-1]], [tuple(self._past)], [self._seat])
        seen: Singles = rows[0]
        return seen

    def play(self, chunk: Singles) -> RoomDecision:
        """Plays the first ticks of a chunk (H, 5); an episode that ends is followed by the next.

        Raises AgentError for whatever the partner raised: its code may be anybody's.
        """
        before = self._done
        if self._spec.own_frame:
            angle = self._past[-1].robot_poses[self._seat, 2]
            chunk = turned(chunk[None], np.array([angle]))[0]
        for tick in range(self._spec.execute):
            self._step(chunk[tick:])
            if self._world.delivered().all():
                break
        finished = bool(self._world.delivered().all())
        over = finished or self._world.tick >= self._distribution.ticks
        gained, last = self._progress() - before, self.features() if over else None
        if over:
            self._open()
        return RoomDecision(gained, over, finished, last)

    def _step(self, rows: Singles) -> None:
        state = self._past[-1]
        holding = bool(state.held[self._seat] >= 0)
        row = agent_rows(rows[:1], holding=holding, levels=self._spec.grasp == "hold")[0]
        both = np.zeros((2, 3))
        both[self._seat] = world_action(row)
        with _in_a_sentence(self._with):
            both[1 - self._seat] = self._partner.action(state)
        self._world.step(both)
        self._past.append(self._world.state())

    def _open(self) -> None:
        """The next episode: another map, partner and seat."""
        distribution, draw = self._distribution, self._random
        the_map = load_map(distribution.maps[draw.integers(len(distribution.maps))])
        family = distribution.partners[draw.integers(len(distribution.partners))]
        partner = family[draw.integers(len(family))]
        self._seat, seed = int(draw.integers(2)), int(draw.integers(2**31))
        self._world = World(the_map, record_sub_poses=False)
        self._with = f"{partner} on {the_map.name}, seed {seed}"
        with _in_a_sentence(self._with):
            episode = EpisodeInfo(the_map, 1 - self._seat, seed, distribution.ticks)
            agent = distribution.load_agent(partner)
            self._partner = SeatPlayer(agent, episode)
            if isinstance(agent, Watcher):
                agent.watch(self._world)
        self._past.clear()
        self._past.append(self._world.state())
        self._progress()

    def _progress(self) -> float:
        """Mean of NFD and TCR now; kept to tell the next gain."""
        items = self._past[-1].item_poses[None]
        delivered = delivered_many(self._world.map, items).astype(np.float64)
        self._done = float(progress(self._world.map, items, delivered)[0])
        return self._done


@contextmanager
def _in_a_sentence(where: str) -> Iterator[None]:
    """Raises AgentError for whatever a partner raises or answers."""
    try:
        yield
    except (AgentError, WorldError) as error:
        raise AgentError(located(f"{where}: {error}", error)) from error
    except MovingOutError:
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(located(f"{where}: {type(error).__name__}: {error}", error)) from error


def play_all(rooms: Sequence[PlayRoom], chunks: Singles) -> VectorStep:
    """One decision in every room, chunks (K, H, 5)."""
    results = [room.play(chunk) for room, chunk in zip(rooms, chunks, strict=True)]
    numbers = np.array([result[:3] for result in results], dtype=np.float64)
    return VectorStep(numbers[:, 0], numbers[:, 1], numbers[:, 2], tuple(result.last for result in results))
