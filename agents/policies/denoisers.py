"""Denoising networks: from a noisy chunk, the time and the observation to the noise or the velocity."""

import math

import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.encoders import FlatEncoder, ItemEncoder, ResidualBlock
from movingout.agents.policies.pictures import ConvolutionalEncoder

TIME_WIDTH = 64
ITEM_WIDTH = 128  # size of an item's embedding


class TimeEmbedding(nn.Module):
    """Sinusoidal embedding of a time in [0, 1], with a resolution of a thousandth."""

    frequencies: Tensor

    def __init__(self) -> None:
        super().__init__()
        half = TIME_WIDTH // 2
        exponents = torch.arange(half, dtype=torch.float32) / (half - 1)
        self.register_buffer("frequencies", 1000.0 * torch.exp(-math.log(10000.0) * exponents), persistent=False)

    def forward(self, time: Tensor) -> Tensor:
        """(B,) to (B, 64)."""
        angles = time[:, None] * self.frequencies
        return torch.cat((angles.sin(), angles.cos()), dim=1)


class ResMlpDenoiser(nn.Module):
    """The fast denoiser: embeddings of observation, chunk and time are summed and pass through residual layers.

    The observation is encoded item by item, or as one vector. For a chunk of 8 x 5 numbers, convolutions do not pay
    off: a step takes 4 MFLOP, that of the U-Net 78.
    """

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__()
        flat = spec.horizon * ACTION_WIDTH
        self.observe = _encoder(spec)
        self.time = TimeEmbedding()
        self.of_time = nn.Sequential(nn.Linear(TIME_WIDTH, spec.width), nn.SiLU(), nn.Linear(spec.width, spec.width))
        self.of_chunk = nn.Linear(flat, spec.width)
        self.blocks = nn.ModuleList([ResidualBlock(spec.width, spec.dropout) for _ in range(spec.depth)])
        self.out = nn.Sequential(nn.LayerNorm(spec.width), nn.Linear(spec.width, flat))

    def condition(self, observation: Tensor) -> Tensor:
        """(B, To x D) to (B, C), computed once per decision."""
        out: Tensor = self.observe(observation)
        return out

    def forward(self, chunk: Tensor, time: Tensor, condition: Tensor) -> Tensor:
        """Chunk (B, H, 5), time (B,), condition (B, C) to (B, H, 5)."""
        hidden = condition + self.of_chunk(chunk.flatten(1)) + self.of_time(self.time(time))
        for block in self.blocks:
            hidden = block(hidden)
        out: Tensor = self.out(hidden).reshape(chunk.shape)
        return out


def _encoder(spec: PolicySpec) -> nn.Module:
    if spec.picture:
        return ConvolutionalEncoder(spec.picture, spec.obs_horizon, spec.width)
    if spec.denoiser == "items":
        return ItemEncoder(spec.width, ITEM_WIDTH, spec.obs_horizon, spec.dropout, FeatureSet.of(spec))
    return FlatEncoder(spec)
