"""Training the embedding of BASS's reward-free progress from episodes (`agents.bass.progress`).

From the top: moments are drawn from an episode in threes, i < j < k with j near i; the embedding of i must lie closer
to that of j than to that of k, and than to that of a moment of another episode (the loss of R3M, Nair et al. 2022, with
negative distances). Validation counts how often the order is right in episodes of people who are not trained on.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.state_vector import CONSTANT_WIDTH, MOVING_WIDTH, constant, moving_arrays
from movingout.agents.checkpoint.card import ProgressSpec
from movingout.agents.data.dataset import Indices, Singles, Trajectory, held_out_episodes
from movingout.agents.errors import DataError
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses

NEAR = 8  # ticks: a positive is at most so far from its anchor
VALIDATION_ROWS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeMoments:
    """All states of many episodes."""

    rows: Singles  # (M, 58)
    constants: Singles  # (E, 146)
    starts: Indices  # (E + 1,) first row of each episode, and the number of rows
    people: tuple[frozenset[str], ...]  # (E,)


def moments_of(trajectories: list[Trajectory]) -> EpisodeMoments:
    """The states of episodes that are long enough to have near and far moments. Raises DataError when none is."""
    kept = [one for one in trajectories if one.ticks > NEAR + 1]
    if not kept:
        raise DataError(
            f"no episode has more than {NEAR + 1} ticks, too short to learn an order in time; use --score nfd"
        )
    rows = [moving_arrays(*one.state_arrays) for one in kept]
    return EpisodeMoments(
        np.concatenate(rows).astype(np.float32),
        np.array([constant(one.map) for one in kept], dtype=np.float32),
        np.cumsum([0, *map(len, rows)]),
        tuple(one.people for one in kept),
    )


class ProgressNetwork(nn.Module):
    """The embedding (B, Z) of moving states (B, 58) on a map with constants (B, 146)."""

    mean: Tensor
    deviation: Tensor

    def __init__(self, spec: ProgressSpec) -> None:
        super().__init__()
        self.spec = spec
        width = MOVING_WIDTH + CONSTANT_WIDTH
        self.register_buffer("mean", torch.zeros(width))
        self.register_buffer("deviation", torch.ones(width))
        self.layers = nn.Sequential(
            nn.Linear(width, spec.width), nn.ReLU(), nn.Linear(spec.width, spec.width), nn.ReLU(),
            nn.Linear(spec.width, spec.latent),
        )  # fmt: skip

    def forward(self, state: Tensor, constant: Tensor) -> Tensor:
        seen = (torch.cat((state, constant), dim=-1) - self.mean) / self.deviation
        embedded: Tensor = self.layers(seen.clamp(-5.0, 5.0))
        return embedded


def train_progress(config: BassConfig, data: EpisodeMoments, folder: Path) -> FitResult[ProgressNetwork]:
    """Fit the embedding; curves and resume file go to `folder`."""
    torch.manual_seed(config.seed)
    network = ProgressNetwork(config.progress_spec())
    _normalise(network, data)
    random = np.random.default_rng(config.seed)
    held = held_out_episodes(data.people, config.held_out, config.seed)
    train, other = np.flatnonzero(~held), np.flatnonzero(held)
    held_out = other if len(other) else train
    fixed = draw_threes(data.starts, held_out, VALIDATION_ROWS, np.random.default_rng(config.seed))

    def losses(embedding: nn.Module) -> Losses:
        return {"loss": _contrast(embedding, data, draw_threes(data.starts, train, config.batch, random))[0]}

    def validate(embedding: nn.Module) -> Losses:
        loss, right = _contrast(embedding, data, fixed)
        return {"contrast": loss, "order": right}

    task = TrainingTask(network, losses, validate, config.progress_updates, random, int(data.starts[-1]))
    trained = fit(task, config, folder)
    assert isinstance(trained.network, ProgressNetwork)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def _normalise(network: ProgressNetwork, data: EpisodeMoments) -> None:
    for start, part in ((0, data.rows), (MOVING_WIDTH, data.constants)):
        there = slice(start, start + part.shape[1])
        network.mean[there] = torch.from_numpy(part.mean(axis=0))
        network.deviation[there] = torch.from_numpy(part.std(axis=0)).clamp(min=0.05)


Threes = tuple[Indices, Indices]
"""Rows (3, B) of anchor, near and far moment, and the episodes (B,) that they are of."""


def draw_threes(starts: Indices, episodes: Indices, count: int, random: np.random.Generator) -> Threes:
    """Threes of these episodes, given the first row of each (E + 1,); none is shorter than NEAR + 2 rows."""
    chosen = random.choice(episodes, count)
    lengths = starts[chosen + 1] - starts[chosen]
    first = (random.random(count) * (lengths - NEAR - 1)).astype(np.int64)
    near = first + random.integers(1, NEAR + 1, count)
    far = near + 1 + (random.random(count) * (lengths - near - 1)).astype(np.int64)
    return starts[chosen] + np.stack((first, near, far)), chosen


def _contrast(network: nn.Module, data: EpisodeMoments, threes: Threes) -> tuple[Tensor, Tensor]:
    """The loss, and the share of threes whose order in time is right."""
    assert isinstance(network, ProgressNetwork)
    rows, episodes = threes
    device = network.mean.device
    states = torch.from_numpy(data.rows[rows.ravel()]).to(device)
    constants = torch.from_numpy(data.constants[episodes]).to(device).repeat(3, 1)
    return contrast(network(states, constants))


def contrast(embedded: Tensor) -> tuple[Tensor, Tensor]:
    """The loss of embedded threes (3 B, Z), first all anchors, and the share whose order in time is right."""
    first, near, far = embedded.chunk(3)
    to_near, to_far = ((first - one).norm(dim=1) for one in (near, far))
    to_other = (first - near.roll(1, dims=0)).norm(dim=1)
    logits = -torch.stack((to_near, to_far, to_other), dim=1)
    loss = F.cross_entropy(logits, torch.zeros(len(first), dtype=torch.long, device=first.device))
    return loss, (to_near < to_far).double().mean()
