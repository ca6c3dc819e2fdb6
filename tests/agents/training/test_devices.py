"""Training goes where the network lies: checked on torch's `meta` device, which refuses tensors of any other."""

import copy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from movingout.agents.bass import dynamics_training, value_training
from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.dynamics_training import train_dynamics, transitions_of
from movingout.agents.bass.value_training import Returns, train_value
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies import training
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.policies.training import train_policy
from movingout.agents.training.fit import FitResult, TrainingTask
from movingout.agents.training.optimisation import Optimisation, Precision
from tests.agents.learning import trajectory_windows, walked

POLICIES: list[tuple[str, dict[str, object]]] = [
    ("mlp", {}),
    ("gru", {"obs_horizon": 3}),
    ("dp", {"pose_noise": 0.01}),
    ("dp", {"denoiser": "unet", "process": "ddpm"}),
    ("dp", {"denoiser": "items"}),
]
SIMULATORS: list[dict[str, object]] = [
    {},
    {"dynamics": "gru"},
    {"dynamics": "qvae"},
    {"order": "separate"},
    {"order": "fine-tuned", "residual": False, "rigid": False},
]
Train = Callable[[Path], object]


def _policy(kind: str, changes: dict[str, object], precision: Precision = "fp32") -> Train:
    config = PolicyConfig(width=16, depth=1, updates=1, batch=8, precision=precision, **changes)  # type: ignore[arg-type]

    windows = trajectory_windows([walked(ticks=20)], "aware-v1", "hold")

    def train(folder: Path) -> object:
        return train_policy(build_policy, config.spec(kind), config, windows, folder)

    return train


def _simulator(changes: dict[str, object], precision: Precision = "fp32") -> Train:
    config = BassConfig(width=16, latent=4, updates=1, batch=8, precision=precision, **changes)  # type: ignore[arg-type]
    return lambda folder: train_dynamics(config, transitions_of([walked(ticks=20)]), folder)


def _value(precision: Precision = "fp32") -> Train:
    data = Returns(np.ones((30, 278), np.float16), np.ones(30, np.float32), np.arange(30) // 3, (frozenset(),) * 10)
    config = BassConfig(value_width=16, value_members=2, value_updates=1, batch=8, precision=precision)
    return lambda folder: train_value(config, data, folder)


@pytest.mark.parametrize(
    "train", [*(_policy(*one) for one in POLICIES), *(_simulator(one) for one in SIMULATORS), _value()]
)
def test_batches_come_to_where_the_network_lies(train: Train, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def fit_elsewhere(task: TrainingTask, config: Optimisation, folder: Path) -> FitResult[nn.Module]:
        elsewhere = copy.deepcopy(task.network).to("meta")
        batch = [part.to("meta") for part in task.draw()] if task.draw else []
        losses = [*task.losses(elsewhere, *batch).values(), *task.validate(elsewhere).values()]
        asked.extend(loss.device.type for loss in losses)
        return FitResult(task.network, 1, 1)

    for module in (training, dynamics_training, value_training):
        monkeypatch.setattr(module, "fit", fit_elsewhere)
    train(tmp_path)
    assert set(asked) == {"meta"}


@pytest.mark.parametrize(
    "train",
    [*(_policy(*one, "bf16") for one in POLICIES), *(_simulator(one, "bf16") for one in SIMULATORS), _value("bf16")],
)
def test_everything_can_be_trained_in_mixed_precision(train: Train, tmp_path: Path) -> None:
    train(tmp_path)  # the loop refuses what is not finite
    assert list(tmp_path.rglob("resume.safetensors"))


def test_validation_leaves_the_random_numbers_of_training_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = []

    def fit_between(task: TrainingTask, config: Optimisation, folder: Path) -> FitResult[nn.Module]:
        for validates in (False, True):
            torch.manual_seed(5)
            first = task.validate(task.network)["loss"] if validates else None
            drawn.append(torch.rand(3).tolist())
            assert first is None or torch.equal(task.validate(task.network)["loss"], first), "always the same noise"
        return FitResult(task.network, 1, 1)

    monkeypatch.setattr(training, "fit", fit_between)
    _policy("dp", {})(tmp_path)
    assert drawn[0] == drawn[1]


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
@pytest.mark.parametrize(
    "train",
    [*(_policy(*one, "bf16") for one in POLICIES), *(_simulator(one, "bf16") for one in SIMULATORS)],
)
def test_a_gpu_takes_the_batches_of_all_networks_in_one_launch(train: Train, tmp_path: Path) -> None:
    train(tmp_path)
    assert list(tmp_path.rglob("resume.safetensors"))
