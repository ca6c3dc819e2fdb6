"""Training the value network of BASS from episodes (`agents.bass.value`).

From the top: episodes become states with the discounted progress that followed; an ensemble is fitted to them, each
member on batches of its own.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.value import progress
from movingout.agents.checkpoint.card import ValueSpec
from movingout.agents.data.dataset import Indices, Singles, Trajectory, split_rows
from movingout.agents.errors import DataError
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.encoders import ItemEncoder, ResidualBlock, alike_for_items
from movingout.agents.policies.own_frame import OwnFrameAugmentation
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses
from movingout.world.observation import AWARE_LAYOUT
from movingout.world.scoring import delivered_many
from movingout.world.state import Floats

TAIL = 60  # ticks dropped at the end of an episode cut off by the time limit: their return is not known
VALIDATION_ROWS = 16384
RETURN_UNIT = 0.1  # brings returns to about 1
NOISE = 0.02  # on normalised features
DECAY = 1e-2
MIRRORED = 0.5  # share of rows that are mirrored, in layouts in the own frame
ITEM_WIDTH = 64
_BOUND = 5.0  # standard deviations; features are clipped to it


@dataclass(frozen=True, slots=True, eq=False)
class Returns:
    """Observations of both seats in many episodes, and the discounted progress that followed."""

    features: npt.NDArray[np.float16]  # (M, D); half precision, for a million rows
    returns: Singles  # (M,)
    episodes: Indices  # (M,) number of the episode
    people: tuple[frozenset[str], ...]  # (E,) who is in each episode


def returns_of(trajectories: Sequence[Trajectory], discount: float, layout: str = AWARE_LAYOUT) -> Returns:
    """All states from which the end of the episode, or at least `TAIL` further ticks, are known.

    Raises DataError when there are none.
    """
    check_long_enough(trajectories)
    features, returns, episodes = [], [], []
    for number, trajectory in enumerate(trajectories):
        seen = [trajectory.features(seat, layout) for seat in (0, 1)]
        done = _progress(trajectory)
        rows = slice(0, _known_ticks(trajectory))
        follows = discounted(np.diff(done), discount)[rows].astype(np.float32)
        features += [view[rows].astype(np.float16) for view in seen]
        returns += [follows, follows]
        episodes.append(np.full(2 * len(follows), number))
    people = tuple(trajectory.people for trajectory in trajectories)
    return Returns(np.concatenate(features), np.concatenate(returns), np.concatenate(episodes), people)


def check_long_enough(trajectories: Sequence[Trajectory]) -> None:
    """Raises DataError when no episode has a state from which enough is known."""
    if not any(map(_known_ticks, trajectories)):
        raise DataError(f"no episode has more than {TAIL} ticks, too short to learn a value from; use --score nfd")


def _known_ticks(trajectory: Trajectory) -> int:
    """From how many of its states what follows is known: from all where everything is delivered in the end."""
    finished = delivered_many(trajectory.map, trajectory.item_poses[-1:]).all()
    return trajectory.ticks if finished else max(trajectory.ticks - TAIL, 0)


def _progress(trajectory: Trajectory) -> Floats:
    """Progress (T + 1,) of an episode; exactly 1 when everything is delivered."""
    delivered = delivered_many(trajectory.map, trajectory.item_poses).astype(np.float64)
    done = progress(trajectory.map, trajectory.item_poses, delivered)
    return np.where(delivered.sum(axis=1) == len(trajectory.map.items), 1.0, done)


def discounted(gains: Floats, discount: float) -> Floats:
    """Discounted sums (T,): over k of discount ** k * gains[t + k]."""
    sums = np.zeros(len(gains))
    follows = 0.0
    for tick in range(len(gains) - 1, -1, -1):
        follows = sums[tick] = gains[tick] + discount * follows
    return sums


class ValueNetwork(nn.Module):
    """Discounted progress (B,) of features (B, D): the mean of an ensemble, or each member's (B, members).

    A single network overrates some candidates, and choosing by it would pick exactly these.
    """

    mean: Tensor
    deviation: Tensor

    def __init__(self, spec: ValueSpec) -> None:
        super().__init__()
        seen = FeatureSet(spec.layout)
        size = seen.size
        self.spec = spec
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("deviation", torch.ones(size))
        self.members = nn.ModuleList(_layers(spec.width, seen) for _ in range(spec.members))

    def forward(self, features: Tensor) -> Tensor:
        normal = self._normal(features)
        if self.spec.each:
            return torch.cat([layers(normal) for layers in self.members], dim=1) * RETURN_UNIT
        value: Tensor = sum(layers(normal)[:, 0] for layers in self.members) * (RETURN_UNIT / len(self.members))
        return value

    def each(self, features: Tensor) -> Tensor:
        """The value of each member (M, B) on its own batch (M, B, D), for training."""
        normal = self._normal(features)
        normal = normal + NOISE * torch.randn_like(normal)
        says = [layers(rows)[:, 0] for layers, rows in zip(self.members, normal, strict=True)]
        return torch.stack(says) * RETURN_UNIT

    def _normal(self, features: Tensor) -> Tensor:
        return ((features - self.mean) / self.deviation).clamp(-_BOUND, _BOUND)


def _layers(width: int, seen: FeatureSet) -> nn.Sequential:
    return nn.Sequential(
        ItemEncoder(width, ITEM_WIDTH, seen=seen),
        ResidualBlock(width),
        nn.LayerNorm(width),
        nn.Linear(width, 1),
    )


def train_value(config: BassConfig, data: Returns, folder: Path) -> FitResult[ValueNetwork]:
    """Fit the value to returns; curves and resume file go to `folder`. Validated like the simulator."""
    torch.manual_seed(config.seed)
    network = ValueNetwork(config.value_spec())
    sample = data.features[::7].astype(np.float32)
    seen = FeatureSet(network.spec.layout)
    augmentation = OwnFrameAugmentation(seen, MIRRORED, 0.0) if seen.own_frame else None
    mean, deviation = alike_for_items(torch.from_numpy(sample.mean(axis=0)), torch.from_numpy(sample.std(axis=0)), seen)
    network.mean.copy_(mean)
    network.deviation.copy_(deviation.clamp(min=1e-2))
    random = np.random.default_rng(config.seed)
    train, held_out = split_rows(data.episodes, data.people, config.held_out, config.seed)
    held_out = random.permutation(held_out)[:VALIDATION_ROWS]

    def batch(value: nn.Module, rows: Indices) -> tuple[Tensor, Tensor]:
        assert isinstance(value, ValueNetwork)
        device = value.mean.device
        features = torch.from_numpy(data.features[rows].astype(np.float32)).to(device)
        return features, torch.from_numpy(data.returns[rows]).to(device)

    def losses(value: nn.Module) -> Losses:
        assert isinstance(value, ValueNetwork)
        features, returns = batch(value, random.choice(train, (config.value_members, config.batch)))
        if augmentation is not None:
            features = augmentation.mirrored_rows(features)
        return {"loss": ((value.each(features) - returns) / RETURN_UNIT).square().mean()}

    def validate(value: nn.Module) -> Losses:
        features, returns = batch(value, held_out)
        says = value(features)
        error = (says.mean(dim=1) if network.spec.each else says) - returns
        return {"explained": 1.0 - (error.square().mean() / returns.var().clamp(min=1e-6)).double()}

    how = dataclasses.replace(config, decay=DECAY)
    trained = fit(TrainingTask(network, losses, validate, config.value_updates, random, len(train)), how, folder)
    assert isinstance(trained.network, ValueNetwork)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)
