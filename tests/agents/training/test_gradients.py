"""Gradients that a GPU computes in one launch are those that it computes step by step."""

import numpy as np
import pytest
import torch
from torch import nn

from movingout.agents.training.gradients import Gradients, Losses

CPU = torch.device("cpu")


def _gradients(device: torch.device, noise: float) -> tuple[nn.Module, Gradients]:
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(3, 16), nn.Tanh(), nn.Linear(16, 1)).to(device)
    random = np.random.default_rng(0)

    def draw() -> tuple[torch.Tensor]:
        return (torch.from_numpy(random.standard_normal((8, 3), dtype=np.float32)),)

    def losses(network: nn.Module, batch: torch.Tensor) -> Losses:
        return {"loss": network(batch + noise * torch.randn_like(batch)).square().mean()}

    return network, Gradients(network, losses, draw, device, mixed=False)


def _learned(device: torch.device, noise: float, updates: int) -> tuple[list[float], torch.Tensor]:
    """The losses, and the weights after plain gradient descent."""
    network, gradients = _gradients(device, noise)
    optimiser, seen = torch.optim.SGD(network.parameters(), 0.1), []
    for _ in range(updates):
        seen.append(float(gradients()["loss"].detach()))
        optimiser.step()
    return seen, torch.cat([weights.detach().cpu().flatten() for weights in network.parameters()])


def test_each_call_has_the_gradients_of_its_own_batch() -> None:
    network, gradients = _gradients(CPU, 0.0)
    again = np.random.default_rng(0)
    for _ in range(2):
        gradients()
        batch = torch.from_numpy(again.standard_normal((8, 3), dtype=np.float32))
        expected = torch.autograd.grad(network(batch).square().mean(), list(network.parameters()))
        found = [weights.grad for weights in network.parameters()]
        assert all(torch.allclose(one, other) for one, other in zip(found, expected, strict=True) if one is not None)
        assert None not in found


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
def test_a_gpu_learns_what_a_cpu_learns() -> None:
    for mine, its in zip(_learned(CPU, 0.0, 8), _learned(torch.device("cuda"), 0.0, 8), strict=True):
        assert torch.allclose(torch.as_tensor(mine), torch.as_tensor(its), atol=1e-5)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
def test_a_gpu_draws_other_noise_for_each_batch_and_the_same_for_the_same_seed() -> None:
    first, again = (_learned(torch.device("cuda"), 1.0, 6)[0] for _ in range(2))
    assert first == again and len(set(first)) == len(first)
