"""The three parts of BASS for the kitchen: a Diffusion Policy, a simulator, and a score of progress.

Policy and simulator are the classes of Moving Out, trained by the same loops. Progress is the discounted number of
soups that follow, learned from the games; what the paper used here it does not say.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.latent.dynamics import LatentDynamics
from movingout.agents.bass.value_training import discounted
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Indices, Windows
from movingout.agents.overcooked.kitchen import KITCHEN_SIZE, Singles
from movingout.agents.overcooked.recordings import KitchenEpisode, kitchen_windows
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.policies.diffusion_policy import DiffusionPolicy
from movingout.agents.policies.policy import Policy
from movingout.agents.policies.training import train_policy
from movingout.agents.training.fit import TrainingTask, fit
from movingout.agents.training.gradients import Losses

NetworkT = TypeVar("NetworkT", bound=nn.Module)
_OfRows = Callable[[nn.Module, Indices], Losses]
"""The losses of some moves."""
DISCOUNT = 0.97  # per tick; a soup takes people some sixty
SELECTION = SelectionSpec(own=4, partner=4, combine="independent", depth=4)  # the paper's, as in Moving Out
ACTION_WIDTH = 4  # distance, cos, sin, press


class KitchenSpec(PolicySpec):
    """A policy's shape, with observations of the kitchen."""

    layout: Literal["cramped-room"] = "cramped-room"  # type: ignore[assignment]

    @property
    def features(self) -> int:
        return KITCHEN_SIZE

    @property
    def own_frame(self) -> bool:
        return False

    @property
    def picture(self) -> None:
        return None


@dataclass(frozen=True, kw_only=True, slots=True)
class KitchenSizes:
    """How much is trained."""

    updates: int  # of the policy
    simulator_updates: int  # of the simulator, and of the progress
    width: int
    batch: int


@dataclass(frozen=True, slots=True)
class KitchenParts:
    """What plays."""

    policy: Policy
    dynamics: LatentDynamics  # from what a cook sees and both cooks' actions to what it sees four ticks later
    value: nn.Module  # from what a cook sees (B, 120) to its progress (B, 1)


def train_cook(windows: Windows, sizes: KitchenSizes, seed: int, folder: Path) -> Policy:
    """Train a policy on windows of the kitchen; as below, a stopped training continues."""
    config = PolicyConfig(
        denoiser="resmlp",
        width=sizes.width,
        batch=sizes.batch,
        updates=sizes.updates,
        seed=seed,
        event_weight=1,
        warmup=min(200, sizes.updates),
    )
    shape = config.spec("dp").model_dump(exclude={"layout"})
    return train_policy(DiffusionPolicy, KitchenSpec(**shape), config, windows, folder).network.eval()


def train_kitchen(episodes: list[KitchenEpisode], sizes: KitchenSizes, seed: int, folder: Path) -> KitchenParts:
    """Train all three on games of people; curves go to `folder`, from where a stopped training continues."""
    width, simulated = sizes.width, sizes.simulator_updates
    policy = train_cook(kitchen_windows(episodes), sizes, seed, folder / "policy")
    config = BassConfig(width=width, batch=sizes.batch, updates=simulated, seed=seed, warmup=min(200, simulated))
    torch.manual_seed(seed)
    dynamics = LatentDynamics(
        lambda size: _layers(KITCHEN_SIZE, width, size), lambda: _layers(config.latent, width, KITCHEN_SIZE),
        2 * ACTION_WIDTH, width, config.latent, residual=True,
    )  # fmt: skip
    moves = _Moves.of(episodes, SELECTION.depth)
    value = _layers(KITCHEN_SIZE, width, 1)
    return KitchenParts(
        policy,
        _fitted(
            dynamics, lambda network, rows: _dynamics_losses(network, moves, rows), moves, config, folder / "dynamics"
        ),
        _fitted(value, lambda network, rows: _value_losses(network, moves, rows), moves, config, folder / "value"),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Moves:
    """What each cook saw, what both did in the ticks after, what it saw then, and the soups that followed."""

    before: Tensor  # (M, 120)
    actions: Tensor  # (M, depth, 8)
    after: Tensor  # (M, 120)
    follows: Tensor  # (M, 1)

    @classmethod
    def of(cls, episodes: list[KitchenEpisode], depth: int) -> "_Moves":
        before, actions, after, follows = [], [], [], []
        for one in episodes:
            starts = np.arange(len(one.rows) - depth)
            sums = discounted(one.soups.astype(np.float64), DISCOUNT)
            for cook in (0, 1):
                rows = np.concatenate([acting_rows(one.rows[:, seat]) for seat in (cook, 1 - cook)], axis=1)
                before.append(one.observations[starts, cook])
                actions.append(rows[starts[:, None] + np.arange(depth)])
                after.append(one.observations[starts + depth, cook])
                follows.append(sums[starts, None])
        parts = (np.concatenate(part).astype(np.float32) for part in (before, actions, after, follows))
        return cls(*map(torch.from_numpy, parts))


def acting_rows(rows: Singles) -> Singles:
    """Rows (..., 5) in the form of the simulator (..., 4): distance, cos, sin, press 0 or 1."""
    press = (rows[..., 4:] > rows[..., 3:4]).astype(np.float32)
    acting: Singles = np.concatenate((rows[..., :3], press), axis=-1)
    return acting


def _fitted(network: NetworkT, losses: _OfRows, moves: _Moves, config: BassConfig, folder: Path) -> NetworkT:
    """The moving average of a network, fitted to all moves."""
    random = np.random.default_rng(config.seed)
    fixed = np.arange(0, len(moves.before), max(len(moves.before) // 512, 1))
    task = TrainingTask(
        network, lambda each: losses(each, random.integers(0, len(moves.before), config.batch)),
        lambda each: losses(each, fixed), config.updates, random, len(moves.before),
    )  # fmt: skip
    fitted = fit(task, config, folder).network
    assert isinstance(fitted, type(network))
    return fitted.cpu().eval()


def _dynamics_losses(network: nn.Module, moves: _Moves, rows: Indices) -> Losses:
    assert isinstance(network, LatentDynamics)
    device = next(network.parameters()).device
    return network.losses(*(part[rows].to(device) for part in (moves.before, moves.actions, moves.after)))


def _value_losses(network: nn.Module, moves: _Moves, rows: Indices) -> Losses:
    device = next(network.parameters()).device
    return {"loss": F.mse_loss(network(moves.before[rows].to(device)), moves.follows[rows].to(device))}


def _layers(inputs: int, width: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, outputs)
    )
