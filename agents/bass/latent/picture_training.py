"""Training the simulator and the progress of BASS from pictures alone: no state vector, no goals, no rewards.

Every seat of an episode is a sequence of its own, in which that seat is blue.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.latent.picture_networks import PictureDynamics, PictureProgress
from movingout.agents.bass.progress_training import NEAR, contrast, draw_threes
from movingout.agents.checkpoint.card import DynamicsSpec
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Indices, Singles, Trajectory, held_out_episodes
from movingout.agents.errors import DataError
from movingout.agents.observation.features import Bytes, FeatureSet
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses

VALIDATION_ROWS = 64


@dataclass(frozen=True, slots=True, eq=False)
class PictureSequences:
    """What each seat of many episodes saw and both did, one sequence after the other."""

    pictures: Bytes  # (M, D)
    actions: Singles  # (M, 2, 4) distance, cos, sin, grasp of the own seat and of the other
    starts: Indices  # (S + 1,) first row of each sequence, and the number of rows
    people: tuple[frozenset[str], ...]  # (S,)
    shape: tuple[int, int, int]

    def __len__(self) -> int:
        return len(self.pictures)


def picture_sequences(trajectories: list[Trajectory], seen: PolicySpec) -> PictureSequences:
    """Those of both seats, with actions as the policy of `seen` gives them. Raises DataError for short episodes."""
    assert seen.picture is not None
    kept = [one for one in trajectories if one.ticks > NEAR + 1]
    if not kept:
        raise DataError(f"no episode has more than {NEAR + 1} ticks, too short to learn an order in time")
    features = FeatureSet.of(seen)
    pictures, actions, people = [], [], []
    for trajectory in kept:
        targets = [trajectory.targets(seat, seen.grasp) for seat in (0, 1)]
        rows = np.stack(targets, axis=1)[..., [0, 1, 2, 4]]  # (T, 2, 4)
        rows[..., 3] = rows[..., 3] > 0.0
        for seat in (0, 1):
            drawn = trajectory.features(seat, features)
            assert drawn.dtype == np.uint8
            pictures.append(drawn.astype(np.uint8, copy=False))
            actions.append(rows[:, [seat, 1 - seat]])
            people.append(trajectory.people)
    starts = np.cumsum([0, *map(len, pictures)])
    return PictureSequences(np.concatenate(pictures), np.concatenate(actions), starts, tuple(people), seen.picture)


def picture_dynamics_spec(config: BassConfig) -> DynamicsSpec:
    """Of the options, those that matter to pictures."""
    return DynamicsSpec(width=config.width, latent=config.latent, residual=config.residual)


def train_picture_dynamics(config: BassConfig, sequences: PictureSequences, folder: Path) -> FitResult[PictureDynamics]:
    """Fit the simulator to what is seen `config.depth` ticks later; curves and resume file go to `folder`."""
    torch.manual_seed(config.seed)
    network = PictureDynamics(picture_dynamics_spec(config), sequences.shape)
    random = np.random.default_rng(config.seed)
    train, held = (_starting_rows(sequences, chosen, config.depth) for chosen in _divided(config, sequences))
    fixed = random.permutation(held)[:VALIDATION_ROWS]

    def losses(dynamics: nn.Module) -> Losses:
        assert isinstance(dynamics, PictureDynamics)
        return dynamics.losses(*_batch(sequences, random.choice(train, config.batch), config.depth, dynamics))

    def validate(dynamics: nn.Module) -> Losses:
        assert isinstance(dynamics, PictureDynamics)
        picture, actions, after = _batch(sequences, fixed, config.depth, dynamics)
        levels = (dynamics(picture, actions) - after).abs().mean()
        return {"levels": levels, "unmoved": (picture - after).abs().mean()}

    updates = -(-config.epochs * len(train) // config.batch) if config.epochs else config.updates
    trained = fit(TrainingTask(network, losses, validate, updates, random, len(train)), config, folder)
    assert isinstance(trained.network, PictureDynamics)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def train_picture_progress(config: BassConfig, sequences: PictureSequences, folder: Path) -> FitResult[PictureProgress]:
    """Fit the embedding by the order of moments; curves and resume file go to `folder`."""
    torch.manual_seed(config.seed)
    network = PictureProgress(config.progress_spec(), sequences.shape)
    random = np.random.default_rng(config.seed)
    train, held = _divided(config, sequences)
    fixed = draw_threes(sequences.starts, held, VALIDATION_ROWS, np.random.default_rng(config.seed))[0]

    def contrasted(embedding: nn.Module, rows: Indices) -> tuple[Tensor, Tensor]:
        device = next(embedding.parameters()).device
        return contrast(embedding(torch.from_numpy(sequences.pictures[rows.ravel()]).to(device)))

    def losses(embedding: nn.Module) -> Losses:
        return {"loss": contrasted(embedding, draw_threes(sequences.starts, train, config.batch, random)[0])[0]}

    def validate(embedding: nn.Module) -> Losses:
        loss, right = contrasted(embedding, fixed)
        return {"contrast": loss, "order": right}

    trained = fit(
        TrainingTask(network, losses, validate, config.progress_updates, random, len(sequences)), config, folder
    )
    assert isinstance(trained.network, PictureProgress)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def _divided(config: BassConfig, sequences: PictureSequences) -> tuple[Indices, Indices]:
    """Sequences for training and for validation, by person; both all where there are too few."""
    held = held_out_episodes(sequences.people, config.held_out, config.seed)
    train, other = np.flatnonzero(~held), np.flatnonzero(held)
    return train, (other if len(other) else train)


def _starting_rows(sequences: PictureSequences, chosen: Indices, depth: int) -> Indices:
    """Rows of these sequences that have `depth` rows after them."""
    return np.concatenate([np.arange(sequences.starts[one], sequences.starts[one + 1] - depth) for one in chosen])


def _batch(sequences: PictureSequences, rows: Indices, depth: int, network: nn.Module) -> tuple[Tensor, Tensor, Tensor]:
    """Pictures (B, D), actions (B, depth, 2, 4) and the pictures after them (B, D), as floats."""
    device = next(network.parameters()).device
    arrays = (
        sequences.pictures[rows],
        sequences.actions[rows[:, None] + np.arange(depth)],
        sequences.pictures[rows + depth],
    )
    picture, actions, after = (torch.from_numpy(array).to(device, torch.float32) for array in arrays)
    return picture, actions, after
