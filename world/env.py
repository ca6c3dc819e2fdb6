"""The world as a PettingZoo ParallelEnv, for reinforcement learning. Needs the extra `env`.

Agents are "blue" and "red"; both act at once, once per tick of 0.1 s. An action is the paper's four numbers
(distance, cos, sin, grasp; `world.action`), an observation a vector of a named layout (`world.observation`) as
float32; of the layout `image-v1` it is a picture (128, 128, 3) of bytes, as networks for pictures take it. A heading is
one of the arena, with the layout `relative-v1` relative to the robot's angle before the tick; (0, 0) keeps that angle.
An episode terminates when everything is delivered and is truncated at its limit of ticks.
`agents.environment` has the same with one learner and a partner, as a Gymnasium Env.
"""

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec, load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.errors import MapError
from movingout.maps.extras import needs_extra
from movingout.maps.json_format import checked_map
from movingout.maps.randomize import SPLITS, Split, randomize
from movingout.maps.spec import SEAT_COLOURS
from movingout.maps.suggestion import known_names
from movingout.world import raster
from movingout.world.action import POLICY_HIGH, POLICY_LOW, POLICY_SIZE, in_arena, to_world
from movingout.world.constants import LIMIT_TICKS, TICKS_PER_SECOND
from movingout.world.errors import ActionError, WorldError
from movingout.world.metrics import METRICS, EpisodeMetrics
from movingout.world.observation import Layout, layout_named
from movingout.world.official_reward import OfficialDenseReward
from movingout.world.physics import Snapshot, World
from movingout.world.reward import PaperReward
from movingout.world.state import Floats, WorldState
from movingout.world.window import Window

with needs_extra("env", "the environment for reinforcement learning"):
    from gymnasium import spaces
    from pettingzoo import ParallelEnv

RewardName = Literal["paper-dense", "paper-agent-distance", "paper-sparse", "official-dense"]
Reward = Callable[[WorldState, WorldState], Floats]
Observation = npt.NDArray[np.float32 | np.uint8]
Info = dict[str, Any]
RenderMode = Literal["rgb_array", "human"]
RENDER_MODES: tuple[RenderMode, ...] = ("rgb_array", "human")
RESET_OPTIONS = ("map",)

REWARDS: dict[RewardName, Callable[[MapSpec], Reward]] = {
    "paper-dense": lambda map_spec: PaperReward(map_spec, dense=True),
    "paper-agent-distance": lambda map_spec: PaperReward(map_spec, carrier=True),
    "paper-sparse": lambda map_spec: PaperReward(map_spec, dense=False),
    "official-dense": OfficialDenseReward,
}
SEEDS = 2**31  # from which those of variants and partners are drawn
_SEEDS_TRIED = 20  # for a variant of one episode
_NO_METRICS = dict.fromkeys((metric.key for metric in METRICS), math.nan)
_REBUILT = ("_world", "_encode", "_metrics", "_reward", "_state", "_window")  # what a copy makes anew


class MovingOutEnv(ParallelEnv[str, Observation, npt.NDArray[np.float32]]):  # type: ignore[misc]  # it is untyped
    """One map, or with `split` a new Challenge 2 variant of it in every episode.

    `map` is a map, a map's name or a map file's path; faults of a file are warned about. Equal seeds of `reset` give
    equal episodes; without `split` every episode starts alike. Seeds for which a tight map has no playable variant are
    passed over, up to 19 in an episode. The info of each agent always has "score" (official,
    [0, 1]) and the metrics of `world.metrics.METRICS` by key, which are NaN until the episode's last tick, and
    afterwards where one has no value.

    It can be pickled and copied in the middle of an episode: the copy simulates the episode's actions again, which
    gives the same floats.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "moving_out_v1",
        "render_modes": list(RENDER_MODES),
        "render_fps": TICKS_PER_SECOND,
        "is_parallelizable": True,
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
        render_mode: RenderMode | None = None,
    ) -> None:
        """Raises WorldError or MapError for arguments that are unknown, naming the known ones."""
        if reward not in REWARDS:
            raise WorldError(f"unknown reward {reward!r}; known: {', '.join(REWARDS)}")
        if isinstance(limit_ticks, bool) or not isinstance(limit_ticks, int | np.integer) or limit_ticks < 1:
            raise WorldError(f"limit_ticks is a whole number of ticks from 1, not {limit_ticks!r}")
        if split is not None and split not in SPLITS:
            raise WorldError(f"unknown split {split!r}; {known_names(str(split), SPLITS)}, None")
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise WorldError(
                f"unknown render mode {render_mode!r}; {known_names(str(render_mode), RENDER_MODES)}, None"
            )
        self._warned: set[MapSpec] = set()
        self.map = self._loaded(map, stacklevel=3)
        self.render_mode = render_mode
        self._window = Window("Moving Out", TICKS_PER_SECOND) if render_mode == "human" else None
        self.possible_agents = list(SEAT_COLOURS)
        self.agents: list[str] = []
        self._reward_name = reward
        self._limit_ticks = limit_ticks
        self._split = split
        self.np_random = np.random.default_rng()  # its name in wrappers, such as SuperSuit's frame_skip
        self._layout = layout
        self.state_space = _box(layout_named(layout))
        self._own_frame = layout_named(layout).own_frame
        self.observation_spaces = {agent: _box(layout_named(layout)) for agent in self.possible_agents}
        low, high = np.array(POLICY_LOW, np.float32), np.array(POLICY_HIGH, np.float32)
        self.action_spaces = {agent: spaces.Box(low, high, dtype=np.float32) for agent in self.possible_agents}
        self._start(self.map)

    def observation_space(self, agent: str) -> spaces.Box:
        """Raises WorldError for an unknown agent."""
        return self.observation_spaces[_known_agent(agent)]

    def action_space(self, agent: str) -> spaces.Box:
        """Raises WorldError for an unknown agent."""
        return self.action_spaces[_known_agent(agent)]

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, Info]]:
        """Start an episode. `seed` seeds the variants from here on; WorldError for one that is no number from 0 on.

        The option "map" (as in the constructor) is played in this episode only; other options are warned about.
        """
        if seed is not None:
            self.np_random = _seeded(seed)
        designed = self._chosen_map(options or {})
        if self._split is None:
            self._start(designed)
        else:
            self._start(self._variant(designed, self._split))
        self.agents = list(self.possible_agents)
        self._show()
        return self._observations(), self._infos()

    def step(
        self, actions: dict[str, npt.NDArray[np.float32]]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Advance by one tick; ActionError for an action that is missing, has the wrong shape or is not finite."""
        self.check_running()
        return self.step_in_arena([self.in_arena(agent, row) for agent, row in _both(actions).items()])

    def check_running(self) -> None:
        """Raises WorldError where no step can be made."""
        if not self.agents:
            raise WorldError("the episode is over or has not begun; call reset() first")

    def in_arena(self, agent: str, action: npt.ArrayLike) -> Floats:
        """An agent's action (4,) with a heading of the arena: of `relative-v1` it is one relative to the own angle.

        Raises ActionError, which names the agent, for a wrong shape.
        """
        angle = float(self._state.robot_poses[SEAT_COLOURS.index(agent), 2])
        return in_arena(checked_row(agent, action), angle, self._own_frame)

    def step_in_arena(
        self, rows: Sequence[Floats]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """`step` with actions (4,) of blue and red whose headings are of the arena."""
        self.check_running()
        rewards = self._advance(to_world(rows)).tolist()
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
        self._show()
        return result

    @property
    def current_map(self) -> MapSpec:
        """The map of this episode: with `split` the variant that was drawn."""
        return self._world.map

    @property
    def world(self) -> World:
        """The world of this episode itself, for oracles."""
        return self._world

    @property
    def world_state(self) -> WorldState:
        """The world before the coming tick, for agents that want more than the vector."""
        return self._state

    def state(self) -> Observation:
        """The whole state as blue sees it (`state_space`); nothing is hidden from either."""
        return self._observations()[SEAT_COLOURS[0]]

    def render(self, seat: int = 0) -> npt.NDArray[np.uint8] | None:
        """The picture (256, 256, 3) with `seat` in blue where `render_mode` is "rgb_array"; else None.

        With "human", every reset and step shows it in a window, ten times a second.
        """
        if self.render_mode is None:
            warnings.warn('render() draws nothing; make the environment with render_mode="rgb_array"', stacklevel=2)
        if self.render_mode != "rgb_array":
            return None
        return raster.pixels(self._world.map, self._state, seat)

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def __getstate__(self) -> dict[str, Any]:
        kept = {name: value for name, value in self.__dict__.items() if name not in _REBUILT}
        return {**kept, "_snapshot": self._world.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        snapshot: Snapshot = state.pop("_snapshot")
        self.__dict__.update(state)
        self._window = Window("Moving Out", TICKS_PER_SECOND) if self.render_mode == "human" else None
        self._start(snapshot.map)
        for actions in np.frombuffer(snapshot.actions).reshape(-1, 2, 3):
            self._advance(actions)

    def _chosen_map(self, options: Mapping[str, Any]) -> MapSpec:
        if not isinstance(options, Mapping):
            raise WorldError(f"options of reset() are a dictionary such as {{'map': 'HandOff'}}, not {options!r}")
        if unknown := [repr(name) for name in options if name not in RESET_OPTIONS]:
            message = f"reset() does not know the option {', '.join(unknown)}; it knows: {', '.join(RESET_OPTIONS)}"
            warnings.warn(message, stacklevel=3)
        return self._loaded(options["map"], stacklevel=4) if "map" in options else self.map

    def _loaded(self, map: MapSpec | str | os.PathLike[str], stacklevel: int) -> MapSpec:
        """The map; cautions about a file are given once. Raises MapError."""
        if isinstance(map, MapSpec):
            return checked_map(map)
        spec = load_map(map)
        if spec not in self._warned:
            self._warned.add(spec)
            for sentence in map_cautions([os.fspath(map)]):
                warnings.warn(sentence, stacklevel=stacklevel)
        return spec

    def _variant(self, designed: MapSpec, split: Split) -> MapSpec:
        """The variant of the next seed with a playable one: on a tight map, some seeds have none. MapError after 20.

        Each seed gets all attempts, so that the seed of an episode alone decides which variant it has.
        """
        for tried in range(_SEEDS_TRIED - 1):
            with suppress(MapError):
                return self._next_variant(designed, split)
            if not tried:
                sentence = f"on {designed.name} not every seed has a playable {split} variant"
                warnings.warn(f"{sentence}; others are tried, which may take minutes", stacklevel=3)
        return self._next_variant(designed, split)

    def _next_variant(self, designed: MapSpec, split: Split) -> MapSpec:
        return randomize(designed, int(self.np_random.integers(SEEDS)), split)

    def _start(self, map_spec: MapSpec) -> None:
        self._encode = layout_named(self._layout).make(map_spec).encode_both
        self._world = World(map_spec, record_sub_poses=False)
        self._metrics = EpisodeMetrics(map_spec)
        self._reward = REWARDS[self._reward_name](map_spec)
        self._state = self._world.state()

    def _advance(self, actions: Floats) -> Floats:
        """One tick with world actions (2, 3); its rewards (2,)."""
        before = self._state
        self._world.step(actions)
        self._state = self._world.state()
        self._metrics.update(before, actions, self._state)
        return self._reward(before, self._state)

    def _observations(self) -> dict[str, Observation]:
        box = self.state_space
        both = np.array(self._encode(self._state), box.dtype).reshape(2, *box.shape)
        np.minimum(both, box.high, out=both)
        np.maximum(both, box.low, out=both)
        return dict(zip(self.possible_agents, both, strict=True))

    def _infos(self, last: bool = False) -> dict[str, Info]:
        info: Info = {"score": self._world.score(), **_NO_METRICS}
        if last:
            values = self._metrics.result().values()
            info |= {key: value for key, value in values.items() if value is not None}
        return {agent: info.copy() for agent in self.possible_agents}

    def _show(self) -> None:
        if self._window is not None:
            self._window.show(raster.pixels(self._world.map, self._state))


def _box(layout: Layout) -> spaces.Box:
    if layout.picture is not None:
        return spaces.Box(0, 255, layout.picture, np.uint8)
    bounds = layout.bounds.astype(np.float32)
    return spaces.Box(-bounds, bounds, dtype=np.float32)


def _known_agent(agent: str) -> str:
    if agent not in SEAT_COLOURS:
        raise WorldError(f"unknown agent {agent!r}; {known_names(str(agent), SEAT_COLOURS)}")
    return agent


def _both(actions: Mapping[str, npt.ArrayLike]) -> dict[str, Floats]:
    """The actions (4,) of the agents. Raises ActionError, which names the agent that has none or a wrong one."""
    if not isinstance(actions, Mapping):
        raise ActionError(f"actions are a dictionary with those of blue and red, not {type(actions).__name__}")
    if missing := [agent for agent in SEAT_COLOURS if agent not in actions]:
        raise ActionError(f"an action for {' and '.join(missing)} is missing; both agents act in every tick")
    if unknown := [agent for agent in actions if agent not in SEAT_COLOURS]:
        raise ActionError(f"there is no agent {unknown[0]!r}; known: {', '.join(SEAT_COLOURS)}")
    return {agent: checked_row(agent, actions[agent]) for agent in SEAT_COLOURS}


def checked_row(agent: str, action: npt.ArrayLike) -> Floats:
    """The action (4,) of an agent. Raises ActionError, which names the agent, for a wrong one."""
    try:
        row = np.asarray(action, np.float64)
    except (TypeError, ValueError, RuntimeError) as error:  # the last for a tensor of torch that requires grad
        raise ActionError(f"{_four_numbers(agent, action)}: {error}") from error
    if row.shape != (POLICY_SIZE,):
        raise ActionError(_four_numbers(agent, action))
    return row


def _four_numbers(agent: str, action: object) -> str:
    return f"an action is 4 numbers (distance, cos, sin, grasp); that of {agent} is {action!r:.80}"


def _seeded(seed: int) -> np.random.Generator:
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise WorldError(f"a seed is a whole number from 0 on, not {seed!r}")
    return np.random.default_rng(seed)
