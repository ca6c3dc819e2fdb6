"""Training any policy from windows: the batches, their augmentation and the weighting of the loss."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import Indices, Windows
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.policies.own_frame import OwnFrameAugmentation
from movingout.agents.policies.policy import MOTION, Policy
from movingout.agents.policies.pose_noise import noisy_partner
from movingout.agents.training.fit import FitResult, TrainingTask, fit
from movingout.agents.training.gradients import Losses
from movingout.world.observation import LAYOUTS

NORMALISER_ROWS = 200_000  # rows from which mean and deviation are estimated
PICTURES = 256  # likewise, of which each has 49,152 numbers
VALIDATION_ROWS = 4096
VALIDATION_PICTURES = 128
SOON = 4  # ticks
HOLDS = 4  # index of the own hand, +1 or -1, in every observation layout
Augmentation = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]
"""Changes observations (B, To, D) and chunks (B, H, 5) of a batch."""


def train_policy(
    build: Callable[[PolicySpec], Policy], spec: PolicySpec, config: PolicyConfig, windows: Windows, folder: Path,
    first: Policy | None = None,
) -> FitResult[Policy]:  # fmt: skip
    """Fit the policy that `build` makes of `spec` to windows; curves and resume file go to `folder`.

    `first`: start from this policy of the same spec instead of random weights; it keeps its normalisation.
    Raises DataError for an invalid configuration.
    """
    config.check()
    torch.manual_seed(config.seed)
    policy = build(spec) if first is None else first
    if first is None:
        fit_normaliser(policy, windows)
    change = augmentation(spec, config)
    random = np.random.default_rng(config.seed)
    train, held_out = _training_rows(windows, config, random, VALIDATION_PICTURES if spec.picture else VALIDATION_ROWS)
    updates = math.ceil(config.epochs * len(train) / config.batch) if config.epochs else config.updates

    def draw() -> tuple[Tensor, Tensor]:
        return change(*_batch(windows, random.choice(train, config.batch), config))

    def losses(network: nn.Module, observation: Tensor, chunk: Tensor) -> Losses:
        return _losses(network, config.grasp_weight, observation, chunk)

    def validate(network: nn.Module) -> Losses:
        with torch.random.fork_rng(drawing_devices(network)):
            torch.manual_seed(1)
            observation, chunk = _batch(windows, held_out, config)
            return _losses(network, config.grasp_weight, observation, chunk)

    trained = fit(TrainingTask(policy, losses, validate, updates, random, len(train), draw), config, folder)
    assert isinstance(trained.network, Policy)
    return FitResult(trained.network.cpu(), trained.updates, trained.made)


def _training_rows(
    windows: Windows, config: PolicyConfig, random: np.random.Generator, validation_rows: int
) -> tuple[Indices, Indices]:
    """Rows to draw batches from, in which grasps occur `event_weight` times, and at most `validation_rows` to validate.

    Where nobody is held out, rows of training validate.
    """
    train, held_out = windows.split(config.held_out, config.seed)
    if config.window_share < 1.0:
        train = random.choice(train, max(int(config.window_share * len(train)), 1), replace=False)
    if config.event_weight > 1:
        train = np.concatenate([train, *[train[hand_changes(windows, train)]] * (config.event_weight - 1)])
    return train, random.permutation(held_out if len(held_out) else train)[:validation_rows]


def drawing_devices(network: nn.Module) -> list[torch.device]:
    """The devices other than the CPU on which the network draws random numbers."""
    return list({parameter.device for parameter in network.parameters() if parameter.is_cuda})


def hand_changes(windows: Windows, rows: Indices) -> npt.NDArray[np.bool_]:
    """Whether the hand is to change within the next ticks (B,), for windows whose targets are levels."""
    wanted = windows.chunks(rows, SOON)[..., 4] > 0
    if windows.features.dtype == np.uint8:  # a picture has no such number; the wanted level is the hand's, or will be
        shown: npt.NDArray[np.bool_] = (wanted != wanted[:, :1]).any(axis=1)
        return shown
    changes: npt.NDArray[np.bool_] = (wanted != (windows.features[rows, HOLDS] > 0)[:, None]).any(axis=1)
    return changes


def augmentation(spec: PolicySpec, config: PolicyConfig) -> Augmentation:
    """What is done to observations and chunks of a batch in training."""
    if spec.own_frame:
        return OwnFrameAugmentation(FeatureSet.of(spec), config.mirror, config.forget if spec.lags else 0.0)
    if config.pose_noise:
        layout = LAYOUTS[spec.layout]
        return lambda observation, chunk: (noisy_partner(observation, config.pose_noise, layout), chunk)
    return _unchanged


def _unchanged(observation: Tensor, chunk: Tensor) -> tuple[Tensor, Tensor]:
    return observation, chunk


def _batch(windows: Windows, rows: Indices, config: PolicyConfig) -> tuple[Tensor, Tensor]:
    """Observations (B, To, D) and chunks (B, H, 5)."""
    observation = windows.observations(rows, config.obs_horizon)
    return torch.from_numpy(observation), torch.from_numpy(windows.chunks(rows, config.horizon))


def _losses(network: nn.Module, grasp_weight: float, observation: Tensor, chunk: Tensor) -> Losses:
    assert isinstance(network, Policy)
    device = network.mean.device
    each = network.loss(observation.to(device), chunk.to(device)).float()
    motion, grasp = each[..., :MOTION].mean(), each[..., MOTION:].mean()
    return {"loss": motion + grasp_weight * grasp, "motion": motion.detach(), "grasp": grasp.detach()}


def fit_normaliser(policy: Policy, windows: Windows) -> None:
    most = PICTURES if policy.spec.picture else NORMALISER_ROWS
    stride = max(len(windows) // most, 1)
    sample = windows.features[::stride].astype(np.float32, copy=False)
    mirror = FeatureSet.of(policy.spec).mirror if policy.spec.own_frame else None
    if mirror is not None:
        order, signs = mirror
        sample = np.concatenate((sample, sample[:, order] * signs.astype(np.float32)))
    policy.fit_normaliser(torch.from_numpy(sample.mean(axis=0)), torch.from_numpy(sample.std(axis=0)))
