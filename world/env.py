"""The world as a PettingZoo ParallelEnv, for reinforcement learning. Needs the extra `env`.

Agents are "blue" and "red"; both act at once, once per tick of 0.1 s. An action is the paper's four numbers
(distance, cos, sin, grasp; `world.action`), an observation a vector of a named layout (`world.observation`) as
float32. An episode terminates when everything is delivered and is truncated at its limit of ticks.
"""

import math
import os
from collections.abc import Callable
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from pettingzoo import ParallelEnv

from movingout.maps import MapSpec, load_map
from movingout.maps.randomize import Split, randomize
from movingout.maps.spec import SEAT_COLOURS
from movingout.world import raster
from movingout.world.action import to_world
from movingout.world.constants import LIMIT_TICKS, TICKS_PER_SECOND
from movingout.world.errors import WorldError
from movingout.world.metrics import EpisodeMetrics
from movingout.world.observation import Encoder
from movingout.world.official_reward import OfficialDenseReward
from movingout.world.physics import World
from movingout.world.reward import PaperReward
from movingout.world.state import Floats, WorldState

RewardName = Literal["paper-dense", "paper-sparse", "official-dense"]
Reward = Callable[[WorldState, WorldState], Floats]
Observation = npt.NDArray[np.float32]
Info = dict[str, Any]

REWARDS: dict[RewardName, Callable[[MapSpec], Reward]] = {
    "paper-dense": lambda map_spec: PaperReward(map_spec, dense=True),
    "paper-sparse": lambda map_spec: PaperReward(map_spec, dense=False),
    "official-dense": OfficialDenseReward,
}
_LARGEST_SEED = 2**31


class MovingOutEnv(ParallelEnv[str, Observation, npt.NDArray[np.float32]]):  # type: ignore[misc]  # it is untyped
    """One map, or with `split` a new Challenge 2 variant of it in every episode.

    `map` is a map, a map's name or a map file's path. Equal seeds of `reset` give equal episodes; without `split`
    every episode starts alike. The info of each agent has "score" (official, [0, 1]); in an episode's last tick also
    the metrics of `world.metrics.METRICS` by key (NaN without a value).
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "moving_out_v1",
        "render_modes": ["rgb_array"],
        "render_fps": TICKS_PER_SECOND,
    }
    _state: WorldState

    def __init__(
        self,
        map: MapSpec | str | os.PathLike[str] = "HandOff",
        *,
        layout: str = "official-v1",
        reward: RewardName = "paper-dense",
        limit_ticks: int = LIMIT_TICKS,
        split: Split | None = None,
        render_mode: Literal["rgb_array"] | None = None,
    ) -> None:
        if reward not in REWARDS:
            raise WorldError(f"unknown reward {reward!r}; known: {', '.join(REWARDS)}")
        if limit_ticks < 1:
            raise WorldError(f"an episode has at least 1 tick, not {limit_ticks}")
        self.map = map if isinstance(map, MapSpec) else load_map(map)
        self.render_mode = render_mode
        self.possible_agents = list(SEAT_COLOURS)
        self.agents: list[str] = []
        self._make_reward = REWARDS[reward]
        self._limit_ticks = limit_ticks
        self._split = split
        self._generator = np.random.default_rng()
        size = Encoder(self.map, layout).layout.size
        low, high = np.array([-1, -1, -1, 0], np.float32), np.ones(4, np.float32)
        self.observation_spaces = {
            agent: spaces.Box(-np.inf, np.inf, (size,), np.float32) for agent in self.possible_agents
        }
        self.action_spaces = {agent: spaces.Box(low, high, dtype=np.float32) for agent in self.possible_agents}
        self._layout = layout
        self._start(self.map)

    def observation_space(self, agent: str) -> spaces.Box:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, Info]]:
        """Start an episode. `seed` seeds the variants from here on; no options are known."""
        if seed is not None:
            self._generator = np.random.default_rng(seed)
        if self._split is None:
            self._start(self.map)
        else:
            self._start(randomize(self.map, int(self._generator.integers(_LARGEST_SEED)), self._split))
        self.agents = list(self.possible_agents)
        return self._observations(), self._infos()

    def step(
        self, actions: dict[str, npt.NDArray[np.float32]]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Advance by one tick; ActionError for an action that has the wrong shape or is not finite."""
        if not self.agents:
            raise WorldError("the episode is over or has not begun; call reset() first")
        before, world_actions = self._state, to_world([actions[agent] for agent in self.agents])
        self._world.step(world_actions)
        self._state = self._world.state()
        self._metrics.update(before, world_actions, self._state)
        rewards = self._reward(before, self._state).tolist()
        terminated = self._world.score() == 1.0
        truncated = not terminated and self._state.tick >= self._limit_ticks
        agents = self.agents
        result = (
            self._observations(),
            dict(zip(agents, rewards, strict=True)),
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            self._infos(last=terminated or truncated),
        )
        if terminated or truncated:
            self.agents = []
        return result

    @property
    def world_state(self) -> WorldState:
        """The world before the coming tick, for agents that want more than the vector."""
        return self._state

    def state(self) -> Observation:
        """The whole state as blue sees it; nothing is hidden from either."""
        return self._encoder.encode(self._state, 0).astype(np.float32)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The picture (256, 256, 3), or None unless `render_mode` is "rgb_array"."""
        if self.render_mode is None:
            return None
        return raster.pixels(self._world.map, self._state)

    def close(self) -> None:
        """Nothing to release."""

    def _start(self, map_spec: MapSpec) -> None:
        self._world = World(map_spec, record_sub_poses=False)
        self._encoder = Encoder(map_spec, self._layout)
        self._metrics = EpisodeMetrics(map_spec)
        self._reward = self._make_reward(map_spec)
        self._state = self._world.state()

    def _observations(self) -> dict[str, Observation]:
        views = (view.astype(np.float32) for view in self._encoder.encode_both(self._state))
        return dict(zip(self.possible_agents, views, strict=True))

    def _infos(self, last: bool = False) -> dict[str, Info]:
        info: Info = {"score": self._world.score()}
        if last:
            values = self._metrics.result().values()
            info |= {key: math.nan if value is None else value for key, value in values.items()}
        return {agent: dict(info) for agent in self.possible_agents}
