"""One environment in which both seats are played by learners or by frozen partners, and which can be put back."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.agents.grasp_encoding import toggles
from movingout.agents.reinforcement.mappo_config import MappoConfig
from movingout.maps import load_map
from movingout.maps.randomize import Split
from movingout.world.action import GRASP_THRESHOLD
from movingout.world.env import MovingOutEnv

Mode = Literal["self", "partner", "mixed"]
MODES: tuple[Mode, ...] = "self", "partner", "mixed"
Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class RoomPairing:
    """Who plays in a room, and how much the reward counts.

    self: the learner in both seats. partner: a frozen partner in the other seat, which changes with every episode.
    mixed: so until a tick drawn for the episode, from then on the learner in both seats; only then it is learned from.
    """

    mode: Mode = "self"
    weight: float = 1.0
    partner: int = -1  # which of the frozen ones


class RoomTick(NamedTuple):
    """What came of a tick."""

    rewards: Singles  # (2,)
    over: bool
    finished: bool  # everything delivered
    seen: Singles  # (2, D) after it, of the episode that may be over
    score: float  # official, of the episode so far


class Kept(NamedTuple):
    """Where a room is."""

    episode: int  # its number
    actions: Singles  # (T, 2, 4) that were played in it


class LearningRoom:
    """One episode after another. What is drawn for an episode follows from seed, room and number of the episode."""

    def __init__(
        self, maps: Sequence[str], config: MappoConfig, split: Split | None, seed: tuple[int, ...], pairing: RoomPairing
    ) -> None:
        self.pairing = pairing
        self._seed, self._ticks, self._levels = seed, config.ticks, config.grasp == "hold"
        self._maps = maps
        self._env = MovingOutEnv(
            load_map(maps[0]), layout=config.layout, reward=config.reward, limit_ticks=config.ticks, split=split
        )
        self._open(0)

    @property
    def partner_seat(self) -> int:
        """Where the frozen partner acts in the coming tick; -1 where it does not."""
        mixed_on = self.pairing.mode == "mixed" and len(self._actions) >= self._switch
        return -1 if self.pairing.mode == "self" or mixed_on else 1 - self.episode % 2

    @property
    def learned(self) -> tuple[bool, bool]:
        """Which seats are learned from in the coming tick."""
        seat = self.partner_seat
        return (True, True) if seat < 0 else (False, False) if self.pairing.mode == "mixed" else (seat == 1, seat == 0)

    def step(self, actions: Singles) -> RoomTick:
        """Play a tick with what both seats want (2, 4); an episode that ends is followed by the next."""
        tick = self._advance(actions)
        if tick.over:
            self._open(self.episode + 1)
        return tick

    def kept(self) -> Kept:
        return Kept(self.episode, np.array(self._actions, np.float32).reshape(-1, 2, 4))

    def put_back(self, kept: Kept) -> None:
        """Play what `kept` told again, which gives the same floats; on other maps, it may end before."""
        self._open(kept.episode)
        for one in kept.actions:
            if self._advance(one).over:
                self._open(kept.episode + 1)
                break

    def _open(self, episode: int) -> None:
        self.episode = episode
        draw = np.random.default_rng([*self._seed, episode])
        the_map = self._maps[(self._seed[-1] + episode) % len(self._maps)]
        self._switch = int(draw.integers(1, max(self._ticks, 2)))
        self._actions: list[Singles] = []
        seen, _ = self._env.reset(seed=int(draw.integers(2**31)), options={"map": load_map(the_map)})
        self.seen: Singles = np.stack(list(seen.values()))

    def _advance(self, actions: Singles) -> RoomTick:
        self._actions.append(actions)
        both = actions.copy()
        if self._levels:
            held = self._env.world_state.held
            for seat in (0, 1):
                level = [actions[seat, 3] > GRASP_THRESHOLD]
                both[seat, 3] = toggles(level, bool(held[seat] >= 0))[0]
        names = self._env.possible_agents
        seen, rewards, terminated, truncated, infos = self._env.step(dict(zip(names, both, strict=True)))
        self.seen = np.stack([seen[name] for name in names])
        first = names[0]
        paid = np.array([rewards[name] for name in names], np.float32)
        score = float(infos[first]["score"])
        return RoomTick(paid, terminated[first] or truncated[first], terminated[first], self.seen, score)
