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


class _ConvBlock(nn.Module):
    """Two convolutions over the ticks of the chunk, the condition scaling and shifting between them (FiLM)."""

    def __init__(self, inputs: int, outputs: int, condition: int) -> None:
        super().__init__()
        self.first = nn.Sequential(nn.Conv1d(inputs, outputs, 5, padding=2), nn.GroupNorm(8, outputs), nn.Mish())
        self.film = nn.Sequential(nn.Mish(), nn.Linear(condition, 2 * outputs))
        self.second = nn.Sequential(nn.Conv1d(outputs, outputs, 5, padding=2), nn.GroupNorm(8, outputs), nn.Mish())
        self.skip = nn.Conv1d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, chunk: Tensor, condition: Tensor) -> Tensor:
        scale, bias = self.film(condition)[:, :, None].chunk(2, dim=1)
        out: Tensor = self.second(scale * self.first(chunk) + bias) + self.skip(chunk)
        return out


class _Level(nn.Module):
    """Two blocks at one resolution."""

    def __init__(self, inputs: int, outputs: int, condition: int) -> None:
        super().__init__()
        self.first = _ConvBlock(inputs, outputs, condition)
        self.second = _ConvBlock(outputs, outputs, condition)

    def forward(self, chunk: Tensor, condition: Tensor) -> Tensor:
        out: Tensor = self.second(self.first(chunk, condition), condition)
        return out


class UNetDenoiser(nn.Module):
    """The paper's 1D U-Net (Chi et al. 2023): widths w, 2 w, 4 w, kernel 5, GroupNorm 8, Mish, FiLM.

    The horizon is a multiple of 4, because the chunk is halved twice.
    """

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__()
        widths = (spec.width, 2 * spec.width, 4 * spec.width)
        observed = spec.width
        self.observe = nn.Sequential(nn.Linear(spec.features * spec.obs_horizon, observed), nn.Dropout(spec.dropout))
        self.time = TimeEmbedding()
        self.of_time = nn.Sequential(nn.Linear(TIME_WIDTH, spec.width), nn.Mish(), nn.Linear(spec.width, spec.width))
        condition = observed + spec.width
        inputs = (ACTION_WIDTH, *widths[:-1])
        self.down = nn.ModuleList([_Level(a, b, condition) for a, b in zip(inputs, widths, strict=True)])
        self.shrink = nn.ModuleList([nn.Conv1d(w, w, 3, stride=2, padding=1) for w in widths[:-1]])
        self.middle = _Level(widths[2], widths[2], condition)
        pairs = [(2 * widths[2], widths[1]), (2 * widths[1], widths[0])]
        self.up = nn.ModuleList([_Level(a, b, condition) for a, b in pairs])
        self.grow = nn.ModuleList([nn.ConvTranspose1d(w, w, 4, stride=2, padding=1) for w in (widths[1], widths[0])])
        self.out = nn.Sequential(
            nn.Conv1d(widths[0], widths[0], 5, padding=2),
            nn.GroupNorm(8, widths[0]),
            nn.Mish(),
            nn.Conv1d(widths[0], ACTION_WIDTH, 1),
        )

    def condition(self, observation: Tensor) -> Tensor:
        """(B, To x D) to (B, C), computed once per decision."""
        out: Tensor = self.observe(observation)
        return out

    def forward(self, chunk: Tensor, time: Tensor, condition: Tensor) -> Tensor:
        """Chunk (B, H, 5), time (B,), condition (B, C) to (B, H, 5)."""
        features = torch.cat((condition, self.of_time(self.time(time)).expand(condition.shape[0], -1)), dim=1)
        hidden = chunk.transpose(1, 2)  # (B, 5, H)
        skips: list[Tensor] = []
        for level, blocks in enumerate(self.down):
            hidden = blocks(hidden, features)
            skips.append(hidden)
            if level < len(self.shrink):
                hidden = self.shrink[level](hidden)
        hidden = self.middle(hidden, features)
        for blocks, grow in zip(self.up, self.grow, strict=True):
            hidden = grow(blocks(torch.cat((hidden, skips.pop()), dim=1), features))
        out: Tensor = self.out(hidden).transpose(1, 2)
        return out
