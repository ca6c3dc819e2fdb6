"""The paper's denoising network: a U-Net over the ticks of a chunk.

Chunks are (B, T, C) here: ticks, then channels. A chunk has eight ticks and fewer, so that convolutions are products of
small matrices: written as such they take a third of the time in onnxruntime, whose own are made for long signals.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.policies.denoisers import TIME_WIDTH, TimeEmbedding

GROUPS = 8  # of channels that are normalised together


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
        self.of_time = nn.Sequential(nn.Linear(TIME_WIDTH, spec.width), _Mish(), nn.Linear(spec.width, spec.width))
        condition = observed + spec.width
        inputs = (ACTION_WIDTH, *widths[:-1])
        self.down = nn.ModuleList([_Level(a, b, condition) for a, b in zip(inputs, widths, strict=True)])
        self.shrink = nn.ModuleList([_Convolution(w, w, 3, stride=2, padding=1) for w in widths[:-1]])
        self.middle = _Level(widths[2], widths[2], condition)
        pairs = [(2 * widths[2], widths[1]), (2 * widths[1], widths[0])]
        self.up = nn.ModuleList([_Level(a, b, condition) for a, b in pairs])
        self.grow = nn.ModuleList([_Doubling(w, w, 4, stride=2, padding=1) for w in (widths[1], widths[0])])
        self.out = nn.Sequential(
            *_convolve(widths[0], widths[0]),
            _Convolution(widths[0], ACTION_WIDTH, 1),
        )

    def condition(self, observation: Tensor) -> Tensor:
        """(B, To x D) to (B, C), computed once per decision."""
        out: Tensor = self.observe(observation)
        return out

    def forward(self, chunk: Tensor, time: Tensor, condition: Tensor) -> Tensor:
        """Chunk (B, H, 5), time (B,), condition (B, C) to (B, H, 5)."""
        features = torch.cat((condition, self.of_time(self.time(time)).expand(condition.shape[0], -1)), dim=1)
        hidden = chunk
        skips: list[Tensor] = []
        for level, blocks in enumerate(self.down):
            hidden = blocks(hidden, features)
            skips.append(hidden)
            if level < len(self.shrink):
                hidden = self.shrink[level](hidden)
        hidden = self.middle(hidden, features)
        for blocks, grow in zip(self.up, self.grow, strict=True):
            hidden = grow(blocks(torch.cat((hidden, skips.pop()), dim=2), features))
        out: Tensor = self.out(hidden)
        return out


class _Level(nn.Module):
    """Two blocks at one resolution."""

    def __init__(self, inputs: int, outputs: int, condition: int) -> None:
        super().__init__()
        self.first = _Block(inputs, outputs, condition)
        self.second = _Block(outputs, outputs, condition)

    def forward(self, chunk: Tensor, condition: Tensor) -> Tensor:
        out: Tensor = self.second(self.first(chunk, condition), condition)
        return out


class _Block(nn.Module):
    """Two convolutions over the ticks of the chunk, the condition scaling and shifting between them (FiLM)."""

    def __init__(self, inputs: int, outputs: int, condition: int) -> None:
        super().__init__()
        self.first = nn.Sequential(*_convolve(inputs, outputs))
        self.film = nn.Sequential(_Mish(), nn.Linear(condition, 2 * outputs))
        self.second = nn.Sequential(*_convolve(outputs, outputs))
        self.skip = _Convolution(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, chunk: Tensor, condition: Tensor) -> Tensor:
        scale, bias = self.film(condition)[:, None].chunk(2, dim=2)
        out: Tensor = self.second(scale * self.first(chunk) + bias) + self.skip(chunk)
        return out


def _convolve(inputs: int, outputs: int) -> tuple[nn.Module, ...]:
    return _Convolution(inputs, outputs, 5, padding=2), _Normalisation(GROUPS, outputs), _Mish()


class _Convolution(nn.Conv1d):
    """A convolution along ticks, (B, T, C) to (B, T', C'), as one product of matrices."""

    def forward(self, chunk: Tensor) -> Tensor:
        ticks, size, padding = int(chunk.shape[1]), self.kernel_size[0], int(self.padding[0])
        if size == 1:
            return functional.linear(chunk, self.weight[:, :, 0], self.bias)
        firsts = range(-padding, ticks + padding - size + 1, self.stride[0])
        taps = [tap for tap in range(size) if any(0 <= first + tap < ticks for first in firsts)]  # others see padding
        padded = functional.pad(chunk, (0, 0, padding, padding))
        last = self.stride[0] * (len(firsts) - 1) + 1
        columns = torch.cat([padded[:, tap : tap + last : self.stride[0]] for tap in taps], dim=2)
        weight = self.weight.transpose(1, 2)[:, taps[0] : taps[-1] + 1].reshape(self.out_channels, -1)
        return functional.linear(columns, weight, self.bias)


class _Doubling(nn.ConvTranspose1d):
    """A transposed convolution along ticks, (B, T, C) to (B, 2 T, C')."""

    def forward(self, chunk: Tensor, output_size: list[int] | None = None) -> Tensor:
        return super().forward(chunk.transpose(1, 2), output_size).transpose(1, 2)


class _Mish(nn.Module):
    """Mish in parts: torch differentiates them several times as fast on a CPU as its own Mish."""

    def forward(self, numbers: Tensor) -> Tensor:
        return numbers * functional.softplus(numbers).tanh()


class _Normalisation(nn.GroupNorm):
    """GroupNorm of (B, T, C)."""

    def forward(self, chunk: Tensor) -> Tensor:
        return super().forward(chunk.transpose(1, 2)).transpose(1, 2)
