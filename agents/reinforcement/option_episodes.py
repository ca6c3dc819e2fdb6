"""Episodes in which one policy over options plays both seats, as decisions and what each of them brought.

Between two decisions of a seat lies a number of ticks (a semi-Markov decision process, Sutton, Precup and Singh 1999):
rewards are discounted per tick within a decision, and so is what follows it.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.data.rollout import SeatPlayer
from movingout.agents.partners.options.features import Singles
from movingout.agents.partners.options.player import OptionPlayer, Scores
from movingout.agents.reinforcement.self_play_config import SelfPlayConfig
from movingout.maps import MapSpec
from movingout.world import World
from movingout.world.distance import paper_distances
from movingout.world.metrics import WEIGHTS
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats, Ints, WorldState

UNIT = 10.0  # brings rewards to about 1


class OptionChoice(NamedTuple):
    """A decision: when, among what (K, SIZE), and which."""

    tick: int
    options: Singles
    chosen: int


class SeatPlay(NamedTuple):
    """The decisions of a seat in an episode, and the reward (N,) and ticks (N,) of each."""

    choices: list[OptionChoice]
    rewards: Floats
    ticks: Ints


class EpisodePlay(NamedTuple):
    """Both seats of an episode, and how it ended."""

    seats: tuple[SeatPlay, SeatPlay]
    progress: float  # mean of NFD and TCR
    delivered: float  # TCR


class RecordingPlayer(OptionPlayer):
    """An `OptionPlayer` that keeps its decisions."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self.choices: list[OptionChoice] = []

    def draw(self, tick: int, features: Singles) -> int:
        chosen = super().draw(tick, features)
        self.choices.append(OptionChoice(tick, features, chosen))
        return chosen


def play_episode(the_map: MapSpec, scores: Scores, seed: int, config: SelfPlayConfig) -> EpisodePlay:
    """Play until everything is delivered, at most `config.ticks` ticks."""
    players = RecordingPlayer(scores), RecordingPlayer(scores)
    seats = [SeatPlayer(player, EpisodeInfo(the_map, seat, seed, config.ticks)) for seat, player in enumerate(players)]
    world = World(the_map, record_sub_poses=False)
    states = [world.state()]
    while world.tick < config.ticks and not world.delivered().all():
        world.step(np.array([seat.action(states[-1]) for seat in seats]))
        states.append(world.state())
    gained, delivered = item_progress(the_map, states)
    held = np.array([state.held for state in states])
    weights = np.array([WEIGHTS[item.size] for item in the_map.items])
    blue, red = (
        _seat_play(player.choices, _rewards(gained, held[:, seat], config), config)
        for seat, player in enumerate(players)
    )
    return EpisodePlay((blue, red), float(gained.sum()), float(delivered[-1] @ weights / weights.sum()))


def item_progress(the_map: MapSpec, states: Sequence[WorldState]) -> tuple[Floats, Floats]:
    """What each item adds to the mean of NFD and TCR in each tick (T, N), and what is delivered (T + 1, N)."""
    poses = np.stack([state.item_poses for state in states])
    delivered = delivered_many(the_map, poses).astype(np.float64)
    distances = paper_distances(the_map)
    left = np.minimum(distances.to_goal(poses[..., :2]), distances.farthest)
    weights = np.array([WEIGHTS[item.size] for item in the_map.items])
    done = delivered * weights / weights.sum() - left / max(float(left[0].sum()), 1e-9)
    return np.diff(done, axis=0) / 2, delivered


def _rewards(gained: Floats, held: Ints, config: SelfPlayConfig) -> Floats:
    """The reward of a seat in each tick (T,), that holds items `held` (T + 1,) at its ends."""
    ticks = np.arange(len(gained))
    own = np.zeros(len(gained))
    for items in (held[:-1], np.where(held[1:] == held[:-1], -1, held[1:])):
        own += np.where(items >= 0, gained[ticks, np.maximum(items, 0)], 0.0)
    rewards: Floats = UNIT * ((1 - config.own) * gained.sum(axis=1) + config.own * own - config.cost)
    return rewards


def _seat_play(choices: list[OptionChoice], rewards: Floats, config: SelfPlayConfig) -> SeatPlay:
    """Rewards of decisions: of their ticks, discounted from the tick of the decision on."""
    bounds = [*(choice.tick for choice in choices), len(rewards)]
    parts = [rewards[start:end] for start, end in pairwise(bounds)]
    sums = [float(part @ config.discount ** np.arange(len(part))) for part in parts]
    return SeatPlay(choices, np.array(sums), np.array([end - start for start, end in pairwise(bounds)]))


def advantages(play: SeatPlay, values: Floats, config: SelfPlayConfig) -> Floats:
    """Generalised advantages (N,) of decisions with `values` (N,); when the episode is over, nothing follows."""
    found, following, value_after = np.zeros(len(values)), 0.0, 0.0
    for index in range(len(values) - 1, -1, -1):
        discount = config.discount ** int(play.ticks[index])
        surprise = play.rewards[index] + discount * value_after - values[index]
        following = surprise + discount * config.trace * following
        found[index], value_after = following, values[index]
    return found
