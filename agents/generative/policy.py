"""A diffusion policy that is told by a latent vector who plays, and the encoder that reads it from an episode.

After GAMMA (Liang et al. 2024): an autoencoder of the partners' play, with one latent per partner and episode. What is
decoded from it is a policy, not the episode.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.policies.diffusion_policy import DiffusionPolicy
from movingout.agents.policies.encoders import ResidualBlock

ROW_WIDTH = 128  # of what the encoder keeps of a window


class Posterior(NamedTuple):
    """A normal distribution of latents (E, Z) with independent numbers."""

    mean: Tensor
    log_variance: Tensor

    def sample(self) -> Tensor:
        """A latent (E, Z) of each."""
        return self.mean + (0.5 * self.log_variance).exp() * torch.randn_like(self.mean)

    @property
    def divergence(self) -> Tensor:
        """From the standard normal distribution [nat], (E,)."""
        each: Tensor = 0.5 * (self.mean**2 + self.log_variance.exp() - 1.0 - self.log_variance)
        return each.sum(dim=1)


class PartnerEncoder(nn.Module):
    """Who plays, from windows of an episode, whatever their order and number."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__()
        self.of_seen = nn.Linear(spec.width, ROW_WIDTH)
        self.of_chunk = nn.Linear(spec.horizon * ACTION_WIDTH, ROW_WIDTH)
        self.row = ResidualBlock(ROW_WIDTH)
        self.out = nn.Sequential(nn.LayerNorm(ROW_WIDTH), nn.Linear(ROW_WIDTH, 2 * spec.latent))

    def forward(self, seen: Tensor, chunk: Tensor) -> Posterior:
        """From encoded observations (E, K, W) and the chunks (E, K, H, 5) that followed them."""
        rows = self.row(F.silu(self.of_seen(seen) + self.of_chunk(chunk.flatten(2))))
        mean, log_variance = self.out(rows.mean(dim=1)).chunk(2, dim=1)
        return Posterior(mean, log_variance.clamp(-8.0, 4.0))


class LatentPolicy(DiffusionPolicy):
    """Turns observations with a latent behind them (B, 1, D + Z) into chunks."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec.model_copy(update={"latent": 0}))
        self.numbers = self.spec.features  # without the latent
        self.spec = spec
        self.of_latent = nn.Sequential(nn.Linear(spec.latent, spec.width), nn.SiLU(), nn.Linear(spec.width, spec.width))
        self.encoder = PartnerEncoder(spec)

    def _condition(self, observation: Tensor) -> Tensor:
        seen, latent = observation[..., : self.numbers], observation[:, 0, self.numbers :]
        told: Tensor = super()._condition(seen) + self.of_latent(latent)
        return told

    def encoded(self, observation: Tensor) -> Tensor:
        """Observations (E, K, D) without a latent, as the policy and the encoder read them: (E, K, W)."""
        return super()._condition(observation.flatten(0, 1)[:, None]).reshape(*observation.shape[:2], -1)

    def chunk_loss(self, seen: Tensor, latent: Tensor, chunk: Tensor) -> Tensor:
        """Loss per number (E, K, H, 5) of encoded windows (E, K, W) for latents (E, Z)."""
        condition = (seen + self.of_latent(latent)[:, None]).flatten(0, 1)
        each: Tensor = self.process.loss(self.denoiser, condition, chunk.flatten(0, 1)).reshape(chunk.shape)
        return each
