"""Training any policy from windows: the batches, their augmentation and the weighting of the loss."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import nn

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Indices, Windows
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.policies.policy import MOTION, Policy
from movingout.agents.policies.pose_noise import noisy_partner
from movingout.agents.training.fit import FitResult, Losses, TrainingTask, fit

NORMALISER_ROWS = 200_000  # rows from which mean and deviation are estimated
VALIDATION_ROWS = 4096
SOON = 4  # ticks
HOLDS = 4  # index of the own hand, +1 or -1, in every observation layout


def train_policy(
    build: Callable[[PolicySpec], Policy], spec: PolicySpec, config: PolicyConfig, windows: Windows, folder: Path
) -> FitResult[Policy]:
    """Fit the policy that `build` makes of `spec` to windows; curves and resume file go to `folder`.

    Raises DataError for an invalid configuration.
    """
    config.check()
    torch.manual_seed(config.seed)
    policy = build(spec)
    _fit_normaliser(policy, windows)
    train, held_out = windows.split(config.held_out, config.seed)
    random = np.random.default_rng(config.seed)
    if config.window_share < 1.0:
        train = random.choice(train, max(int(config.window_share * len(train)), 1), replace=False)
    if config.event_weight > 1:
        train = np.concatenate([train, *[train[hand_changes(windows, train)]] * (config.event_weight - 1)])
    held_out = random.permutation(held_out if len(held_out) else train)[:VALIDATION_ROWS]
    updates = math.ceil(config.epochs * len(train) / config.batch) if config.epochs else config.updates

    def losses(network: nn.Module) -> Losses:
        return _losses(network, config, windows, random.choice(train, config.batch), augment=True)

    def validate(network: nn.Module) -> Losses:
        with torch.random.fork_rng(_gpus(network)):
            torch.manual_seed(1)
            return _losses(network, config, windows, held_out)

    trained = fit(TrainingTask(policy, losses, validate, updates, random, len(train)), config, folder)
    assert isinstance(trained.network, Policy)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def _gpus(network: nn.Module) -> list[torch.device]:
    """The devices other than the CPU on which the network draws random numbers."""
    return list({parameter.device for parameter in network.parameters() if parameter.is_cuda})


def hand_changes(windows: Windows, rows: Indices) -> npt.NDArray[np.bool_]:
    """Whether the hand is to change within the next ticks (B,), for windows whose targets are levels."""
    wanted = windows.chunks(rows, SOON)[..., 4] > 0
    changes: npt.NDArray[np.bool_] = (wanted != (windows.features[rows, HOLDS] > 0)[:, None]).any(axis=1)
    return changes


def _losses(network: nn.Module, config: PolicyConfig, windows: Windows, rows: Indices, augment: bool = False) -> Losses:
    assert isinstance(network, Policy)
    device = network.mean.device
    observation = torch.from_numpy(windows.observations(rows, config.obs_horizon)).to(device)
    chunk = torch.from_numpy(windows.chunks(rows, config.horizon)).to(device)
    if augment and config.pose_noise:
        observation = noisy_partner(observation, config.pose_noise)
    each = network.loss(observation, chunk).float()
    motion, grasp = each[..., :MOTION].mean(), each[..., MOTION:].mean()
    return {"loss": motion + config.grasp_weight * grasp, "motion": motion.detach(), "grasp": grasp.detach()}


def _fit_normaliser(policy: Policy, windows: Windows) -> None:
    stride = max(len(windows) // NORMALISER_ROWS, 1)
    sample = windows.features[::stride]
    policy.fit_normaliser(torch.from_numpy(sample.mean(axis=0)), torch.from_numpy(sample.std(axis=0)))
