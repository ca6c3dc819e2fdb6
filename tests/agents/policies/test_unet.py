"""The U-Net: its convolutions are those of torch, and what was trained with those plays on."""

import pytest
import torch
from torch import nn

from movingout.agents.policies.unet import UNetDenoiser, _Convolution, _Mish
from tests.agents.learning import tiny_spec


@pytest.mark.parametrize("ticks", [1, 2, 4, 8])
@pytest.mark.parametrize(("size", "stride", "padding"), [(5, 1, 2), (3, 2, 1), (1, 1, 0)])
def test_a_convolution_is_that_of_torch(ticks: int, size: int, stride: int, padding: int) -> None:
    torch.manual_seed(0)
    ours = _Convolution(6, 10, size, stride=stride, padding=padding)
    theirs = nn.Conv1d(6, 10, size, stride=stride, padding=padding)
    theirs.load_state_dict(ours.state_dict())
    chunk = torch.randn(3, ticks, 6, requires_grad=True)
    assert torch.allclose(ours(chunk), theirs(chunk.transpose(1, 2)).transpose(1, 2), atol=1e-6)
    for network in ours, theirs:
        network(chunk if network is ours else chunk.transpose(1, 2)).square().sum().backward()
    assert torch.allclose(ours.weight.grad, theirs.weight.grad, atol=1e-5)  # type: ignore[arg-type]


def test_mish_is_that_of_torch() -> None:
    numbers = torch.linspace(-60.0, 60.0, 200)
    assert torch.allclose(_Mish()(numbers), nn.functional.mish(numbers), atol=1e-6)


def test_the_weights_have_the_names_and_shapes_of_convolutions() -> None:
    """Checkpoints of earlier versions, which used torch's own, are read."""
    weights = UNetDenoiser(tiny_spec(denoiser="unet", width=16)).state_dict()
    shapes = {name: tuple(weight.shape) for name, weight in weights.items()}
    assert shapes["down.0.first.first.0.weight"] == (16, 5, 5)
    assert shapes["down.0.first.skip.weight"] == (16, 5, 1)
    assert shapes["shrink.0.weight"] == (16, 16, 3)
    assert shapes["grow.0.weight"] == (32, 32, 4)
    assert shapes["out.3.weight"] == (5, 16, 1)


@pytest.mark.parametrize("horizon", [4, 8, 16])
def test_a_chunk_keeps_its_shape_and_learns_everywhere(horizon: int) -> None:
    torch.manual_seed(0)
    spec = tiny_spec(denoiser="unet", width=16, horizon=horizon)
    network = UNetDenoiser(spec)
    condition = network.condition(torch.randn(3, spec.obs_horizon * spec.features))
    out = network(torch.randn(3, horizon, 5), torch.rand(3), condition)
    out.square().sum().backward()
    assert out.shape == (3, horizon, 5)
    assert all(parameter.grad is not None for parameter in network.parameters())
