"""One seat as a Gymnasium Env; an agent plays the other: `gymnasium.make("MovingOut-v1")`. Needs the extra `env`.

It is `world.env.MovingOutEnv` seen from one seat: the same actions, layouts of observations, rewards and variants.
"""

import inspect
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal, cast

import numpy as np
import numpy.typing as npt

from movingout.agents.base import EpisodeInfo
from movingout.agents.environment.partners import PartnerSeat, partner_groups
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import outrun_cautions
from movingout.agents.map_limits import check_own_maps_seen
from movingout.maps import MapSpec, Rect
from movingout.maps.extras import needs_extra
from movingout.maps.randomize import Split
from movingout.maps.spec import SEAT_COLOURS
from movingout.maps.suggestion import known_names
from movingout.world.action import to_world
from movingout.world.constants import LIMIT_TICKS
from movingout.world.env import SEEDS, Info, MovingOutEnv, Observation, RenderMode, RewardName
from movingout.world.errors import WorldError

with needs_extra("env", "the environment for reinforcement learning"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.utils import EzPickle

Action = npt.NDArray[np.float32]


class SeatEnv(gymnasium.Env[Observation, Action], EzPickle):
    """The learner plays `seat`; in every episode one of `partner` plays the other, drawn evenly.

    `partner` is the id of an agent (`scripted`, `dp@all`, `package.module:Factory`), `people:A` for one of the twenty
    scripted people of a population, or a list of these. The other arguments are those of `MovingOutEnv`. The info
    always has "score" and "partner"; in the last tick also the metrics, by key (Gymnasium's `max_episode_steps` ends an
    episode before it: use `limit_ticks`). Equal seeds of `reset` give equal variants, partners and seeds of partners.
    A copy or a pickle starts anew: it needs a `reset`.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]  # theirs is one of instances
        "render_modes": MovingOutEnv.metadata["render_modes"],
        "render_fps": MovingOutEnv.metadata["render_fps"],
    }

    def __init__(
        self,
        map: MapSpec | str | os.PathLike[str] = "HandOff",
        *,
        partner: str | Sequence[str] = "scripted",
        seat: Literal["blue", "red"] = "blue",
        layout: str = "official-v1",
        reward: RewardName = "paper-dense",
        limit_ticks: int = LIMIT_TICKS,
        split: Split | None = None,
        render_mode: RenderMode | None = None,
    ) -> None:
        """Raises AgentError, WorldError or MapError, which name what is known, for arguments that are not."""
        common: dict[str, Any] = {"layout": layout, "reward": reward, "limit_ticks": limit_ticks, "split": split}
        EzPickle.__init__(self, map, partner=partner, seat=seat, render_mode=render_mode, **common)
        if seat not in SEAT_COLOURS:
            raise AgentError(f"unknown seat {seat!r}; {known_names(str(seat), SEAT_COLOURS)}")
        self._env = MovingOutEnv(map, render_mode=render_mode, **common)
        self._seat = SEAT_COLOURS.index(seat)
        self._colour = seat
        self._limit_ticks = limit_ticks
        self._groups = partner_groups(partner)
        for sentence in outrun_cautions(agent_id for group in self._groups for agent_id in group):
            warnings.warn(sentence, stacklevel=2)
        self._seen: set[tuple[tuple[Rect, ...], tuple[Rect, ...]]] = set()  # walls and goals that all partners see
        self._check_seen(self._env.map)
        self._partners: dict[str, PartnerSeat] = {}
        self._partner: PartnerSeat | None = None
        self.render_mode = render_mode
        self.observation_space = cast("spaces.Space[Observation]", self._env.observation_space(seat))
        self.action_space = cast("spaces.Space[Action]", self._env.action_space(seat))

    @property
    def current_map(self) -> MapSpec:
        """The map of this episode: with `split` the variant that was drawn."""
        return self._env.current_map

    @property
    def partner(self) -> str:
        """The id of this episode's partner. Raises WorldError before the first `reset`, which draws it."""
        if self._partner is None:
            raise WorldError("the partner is drawn when an episode begins; call reset() first")
        return self._partner.agent_id

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode with a drawn partner. Options as of `MovingOutEnv.reset`."""
        super().reset(seed=seed)
        group = self._groups[self.np_random.integers(len(self._groups))]
        agent_id = group[self.np_random.integers(len(group))]
        variant, partner_seed = self.np_random.integers(SEEDS, size=2)
        observations, infos = self._env.reset(int(variant), options)
        self._check_seen(self.current_map)
        partner = self._partners.get(agent_id) or self._partners.setdefault(agent_id, PartnerSeat(agent_id))
        self._partner = partner
        episode = EpisodeInfo(self.current_map, 1 - self._seat, int(partner_seed), self._limit_ticks)
        partner.reset(episode, self._env.world)
        return observations[self._colour], self._info(infos, last=False)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advance by one tick. Raises ActionError for an action of a wrong shape, AgentError for the partner's.

        Raises WorldError before `reset`.
        """
        env = self._env
        env.check_running()
        if self._partner is None:
            raise WorldError("the partner was not drawn; call reset() first")
        own = env.in_arena(self._colour, action)
        to_world(own)  # a partner who is asked for a step that is refused moves on
        partners = self._partner.action(env.world_state)
        rows = [own, partners] if self._seat == 0 else [partners, own]
        observations, rewards, terminated, truncated, infos = env.step_in_arena(rows)
        over = terminated[self._colour] or truncated[self._colour]
        return (
            observations[self._colour],
            rewards[self._colour],
            terminated[self._colour],
            truncated[self._colour],
            self._info(infos, last=over),
        )

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The picture (256, 256, 3) as the learner's seat sees it, where `render_mode` is "rgb_array"."""
        return self._env.render(self._seat)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._env.close()

    def _check_seen(self, spec: MapSpec) -> None:
        """Raises AgentError for a map with more than one of the partners sees, before that one is drawn."""
        ground = spec.walls, spec.goals
        if ground not in self._seen:
            check_own_maps_seen((agent_id, spec) for group in self._groups for agent_id in group)
            self._seen.add(ground)

    def _info(self, infos: dict[str, Info], last: bool) -> dict[str, Any]:
        """NaN, which Gymnasium's checker takes for a difference, is in the last info only."""
        info = infos[self._colour]
        return {**(info if last else {"score": info["score"]}), "partner": self.partner}


def make_seat_env(**options: Any) -> SeatEnv:
    """A `SeatEnv` for `gymnasium.make`. Raises TypeError, with those that it takes, for an unknown option.

    In Python's own words: TorchRL tries `frameskip`, and goes without it if it reads them.
    """
    known = tuple(inspect.signature(SeatEnv).parameters)
    for name in options:
        if name not in known:
            raise TypeError(f"unexpected keyword argument {name!r}; {known_names(name, known)}")
    return SeatEnv(**options)


make_seat_env.metadata = SeatEnv.metadata  # type: ignore[attr-defined]  # Gymnasium reads render modes there
