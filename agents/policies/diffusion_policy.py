"""Diffusion Policy: a chunk is made out of noise, by flow matching or by denoising diffusion (DDPM or DDIM sampling).

From the top: the policy conditions a denoising network on the observation; its process says what that network learns
(`loss`) and how a chunk is sampled with it (`sample`). Noise is an argument of `sample`, so that a decision can be
repeated exactly and the whole sampler becomes one ONNX graph.
"""

import math
from typing import Protocol

import torch
from torch import Tensor

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.policies.denoisers import ResMlpDenoiser
from movingout.agents.policies.policy import Policy
from movingout.agents.policies.unet import UNetDenoiser

MAX_BETA = 0.999


class DiffusionPolicy(Policy):
    """Diffusion Policy with the U-Net or the fast denoiser, by diffusion or by flow."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.denoiser = UNetDenoiser(spec) if spec.denoiser == "unet" else ResMlpDenoiser(spec)
        self.process = make_process(spec)

    @property
    def noise_rows(self) -> int:
        """One to begin with; DDPM draws fresh noise in every step."""
        return self.spec.sample_steps if self.spec.process == "ddpm" else 1

    def _condition(self, observation: Tensor) -> Tensor:
        return self.denoiser.condition(self.normalised(observation).flatten(1))

    def loss(self, observation: Tensor, chunk: Tensor) -> Tensor:
        return self.process.loss(self.denoiser, self._condition(observation), chunk)

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        return self.process.sample(self.denoiser, self._condition(observation), noise)


class Denoiser(Protocol):
    def __call__(self, chunk: Tensor, time: Tensor, condition: Tensor) -> Tensor: ...


class Process(Protocol):
    def loss(self, denoiser: Denoiser, condition: Tensor, chunk: Tensor) -> Tensor: ...

    def sample(self, denoiser: Denoiser, condition: Tensor, noise: Tensor) -> Tensor: ...


def make_process(spec: PolicySpec) -> Process:
    """The process that a spec names."""
    if spec.process == "flow":
        return Flow(spec.sample_steps)
    return Diffusion(spec.train_steps, spec.sample_steps, fresh_noise=spec.process == "ddpm")


class Flow:
    """Flow matching on straight lines from noise (time 0) to data (time 1); the network predicts the velocity."""

    def __init__(self, steps: int) -> None:
        self.steps = steps

    def loss(self, denoiser: Denoiser, condition: Tensor, chunk: Tensor) -> Tensor:
        """Squared error of the velocity, (B, H, 5)."""
        noise = torch.randn_like(chunk)
        time = torch.rand(chunk.shape[0], device=chunk.device)
        along = time[:, None, None]
        velocity = denoiser((1 - along) * noise + along * chunk, time, condition)
        return (velocity - (chunk - noise)) ** 2

    def sample(self, denoiser: Denoiser, condition: Tensor, noise: Tensor) -> Tensor:
        """Euler steps from noise (B, 1, H, 5) to a chunk (B, H, 5)."""
        chunk = noise[:, 0]
        for step in range(self.steps):
            time = torch.full((1,), step / self.steps, device=chunk.device)
            chunk = chunk + denoiser(chunk, time, condition) / self.steps
        return chunk


class Diffusion:
    """Denoising diffusion with the squared-cosine schedule, predicting the noise, samples clipped to [-1, 1].

    Fewer steps than in training jump over times of the same schedule, which keeps what was learned valid.
    """

    def __init__(self, train_steps: int, sample_steps: int, *, fresh_noise: bool) -> None:
        self.train_steps = train_steps
        self.steps = min(sample_steps, train_steps)
        self.fresh_noise = fresh_noise
        self.alphas = torch.tensor(_cumulative_alphas(train_steps), dtype=torch.float32)
        self._there = self.alphas  # where chunks are

    def loss(self, denoiser: Denoiser, condition: Tensor, chunk: Tensor) -> Tensor:
        """Squared error of the noise, (B, H, 5)."""
        noise = torch.randn_like(chunk)
        step = torch.randint(self.train_steps, (chunk.shape[0],), device=chunk.device)
        if self._there.device != chunk.device:  # kept: no copy from the CPU in every update on a GPU
            self._there = self.alphas.to(chunk.device)
        alpha = self._there[step][:, None, None]
        noisy = alpha.sqrt() * chunk + (1 - alpha).sqrt() * noise
        return (denoiser(noisy, step / self.train_steps, condition) - noise) ** 2

    def sample(self, denoiser: Denoiser, condition: Tensor, noise: Tensor) -> Tensor:
        """From noise (B, 1, H, 5), or (B, steps, H, 5) for DDPM, to a chunk (B, H, 5)."""
        stride = self.train_steps / self.steps
        times = [round((self.steps - 1 - k) * stride) for k in range(self.steps)]
        chunk = noise[:, 0]
        for k, step in enumerate(times):
            alpha = float(self.alphas[step])
            before = float(self.alphas[times[k + 1]]) if k + 1 < self.steps else 1.0
            time = torch.full((1,), step / self.train_steps, device=chunk.device)
            predicted = denoiser(chunk, time, condition)
            clean = ((chunk - math.sqrt(1 - alpha) * predicted) / math.sqrt(alpha)).clamp(-1.0, 1.0)
            predicted = (chunk - math.sqrt(alpha) * clean) / math.sqrt(1 - alpha)
            variance = (1 - before) / (1 - alpha) * (1 - alpha / before) if self.fresh_noise else 0.0
            chunk = math.sqrt(before) * clean + math.sqrt(max(1 - before - variance, 0.0)) * predicted
            if variance > 0.0:
                chunk = chunk + math.sqrt(variance) * noise[:, k + 1]
        return chunk


def _cumulative_alphas(steps: int) -> list[float]:
    """The squared-cosine schedule of Nichol and Dhariwal 2021, betas at most 0.999."""

    def bar(time: float) -> float:
        return math.cos((time + 0.008) / 1.008 * math.pi / 2) ** 2

    product, products = 1.0, []
    for step in range(steps):
        product *= 1 - min(1 - bar((step + 1) / steps) / bar(step / steps), MAX_BETA)
        products.append(product)
    return products
