"""Training the generative model of partners: half of an episode's windows says who plays in the other half.

The loss is that of an autoencoder with a prior (a bound on the evidence, as far as the loss of flow matching stands for
a likelihood). A latent that is read from the windows it explains may describe these windows; one that is read from
others of the same episode can only describe who plays.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Indices, Windows
from movingout.agents.generative.config import LatentConfig
from movingout.agents.generative.policy import LatentPolicy
from movingout.agents.policies.policy import MOTION
from movingout.agents.policies.training import augmentation, drawing_devices, fit_normaliser
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses

VALIDATION_EPISODES = 128


class Episodes(NamedTuple):
    """Where episodes lie among rows of windows: the first row (E,) and the number of rows (E,) of each."""

    first: Indices
    lengths: Indices

    def drawn(self, count: int, each: int, random: np.random.Generator) -> Indices:
        """Rows (count, each) of episodes drawn at random; without a row twice where there are enough."""
        chosen = random.choice(len(self.first), count, replace=count > len(self.first))
        return np.stack([self._rows(episode, each, random) for episode in chosen])

    def _rows(self, episode: int, each: int, random: np.random.Generator) -> Indices:
        length = int(self.lengths[episode])
        rows: Indices = self.first[episode] + random.choice(length, each, replace=each > length)
        return rows


class Batch(NamedTuple):
    """Windows of some episodes: observations (E, K, D) and chunks (E, K, H, 5)."""

    observation: Tensor
    chunk: Tensor


def episodes_of(windows: Windows, rows: Indices) -> Episodes:
    """The episodes that rows of windows are of."""
    first, lengths = np.unique(windows.starts[rows], return_counts=True)
    return Episodes(first, lengths)


def train_latent(spec: PolicySpec, config: LatentConfig, windows: Windows, folder: Path) -> FitResult[LatentPolicy]:
    """Fit policy and encoder to windows of whole episodes. Raises DataError for an invalid configuration."""
    config.check()
    torch.manual_seed(config.seed)
    policy = LatentPolicy(spec)
    fit_normaliser(policy, windows)
    train, held_out = windows.split(config.held_out, config.seed)
    learned, tested = (episodes_of(windows, rows) for rows in (train, held_out if len(held_out) else train))
    random, change = np.random.default_rng(config.seed), augmentation(spec, config)
    shown = tested.drawn(min(VALIDATION_EPISODES, len(tested.first)), config.episode_windows, random)
    updates = math.ceil(config.epochs * len(train) / config.batch) if config.epochs else config.updates

    def losses(network: nn.Module) -> Losses:
        rows = learned.drawn(config.batch_episodes, config.episode_windows, random)
        observation, chunk = change(*_windows(windows, rows.flatten(), config.horizon))
        return _losses(network, config, _batch(observation, chunk, config))

    def validate(network: nn.Module) -> Losses:
        with torch.random.fork_rng(drawing_devices(network)):
            batch = _batch(*_windows(windows, shown.flatten(), config.horizon), config)
            return _validated(network, config, batch)

    trained = fit(TrainingTask(policy, losses, validate, updates, random, len(train)), config, folder)
    assert isinstance(trained.network, LatentPolicy)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def _windows(windows: Windows, rows: Indices, horizon: int) -> tuple[Tensor, Tensor]:
    return torch.from_numpy(windows.observations(rows, 1)), torch.from_numpy(windows.chunks(rows, horizon))


def _batch(observation: Tensor, chunk: Tensor, config: LatentConfig) -> Batch:
    """Windows (B, 1, D) and (B, H, 5), the same number of each episode."""
    each = config.episode_windows
    return Batch(observation.reshape(-1, each, observation.shape[-1]), chunk.reshape(-1, each, *chunk.shape[1:]))


def _losses(network: nn.Module, config: LatentConfig, batch: Batch) -> Losses:
    """The bound, and what it is made of."""
    assert isinstance(network, LatentPolicy)
    batch = Batch(*(part.to(network.mean.device) for part in batch))
    seen, half = network.encoded(batch.observation), config.episode_windows // 2
    told = [network.encoder(seen[:, part], batch.chunk[:, part]) for part in (slice(half), slice(half, None))]
    each = torch.cat(
        [
            network.chunk_loss(seen[:, half:], told[0].sample(), batch.chunk[:, half:]),
            network.chunk_loss(seen[:, :half], told[1].sample(), batch.chunk[:, :half]),
        ]
    ).float()
    divergence = torch.cat([one.divergence for one in told]).float().mean()
    motion, grasp = each[..., :MOTION].mean(), each[..., MOTION:].mean()
    loss = motion + config.grasp_weight * grasp + config.beta * divergence
    return {
        "loss": loss, "motion": motion.detach(), "grasp": grasp.detach(), "divergence": divergence.detach()
    }  # fmt: skip


def _validated(network: nn.Module, config: LatentConfig, batch: Batch) -> Losses:
    """The same on partners that are not learned from, and what is lost without their latent or with that of another."""
    assert isinstance(network, LatentPolicy)
    torch.manual_seed(1)
    found = _losses(network, config, batch)
    batch = Batch(*(part.to(network.mean.device) for part in batch))
    half = config.episode_windows // 2
    seen = network.encoded(batch.observation)
    own = network.encoder(seen[:, :half], batch.chunk[:, :half]).mean
    for name, latent in (("own", own), ("without", torch.zeros_like(own)), ("another", own.roll(1, dims=0))):
        torch.manual_seed(2)  # the same noise for all three
        found[name] = network.chunk_loss(seen[:, half:], latent, batch.chunk[:, half:])[..., :MOTION].float().mean()
    return found
