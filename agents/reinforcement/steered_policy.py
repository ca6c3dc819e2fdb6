"""A diffusion policy whose noise is chosen instead of drawn: what reinforcement learning changes of an imitated policy.

The imitated policy stays as it is. A small network, the steering, looks at the same observation and says where in the
space of noise to sample: loc + scale * noise. At first loc is 0 and scale 1, which is the imitated policy itself; how
far the steering has gone from it, the leash, is the Kullback-Leibler divergence from the standard normal distribution.
(Steering a diffusion policy by its noise: Wagenmaker et al. 2025, "Steering Your Diffusion Policy with Latent Space
Reinforcement Learning".) With the steering inside, the whole is one graph with the inputs of a diffusion policy.
"""

import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.errors import DataError
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.diffusion_policy import DiffusionPolicy
from movingout.agents.policies.encoders import ItemEncoder, ResidualBlock
from movingout.agents.policies.policy import CLIP, Policy

WIDTH, ITEM_WIDTH = 128, 64
_LEAST, _MOST = -2.0, 0.5  # of ln(scale)


class Steering(nn.Module):
    """From normalised features (B, D) to loc and scale (B, N) of the noise; 0 and 1 before any training."""

    def __init__(self, spec: PolicySpec, noise: int) -> None:
        super().__init__()
        self.body = nn.Sequential(
            ItemEncoder(WIDTH, ITEM_WIDTH, seen=FeatureSet.of(spec)), ResidualBlock(WIDTH), nn.LayerNorm(WIDTH)
        )
        self.head = nn.Linear(WIDTH, 2 * noise)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor]:
        loc, log_scale = self.head(self.body(features)).chunk(2, dim=-1)
        return loc, log_scale.clamp(_LEAST, _MOST).exp()


class SteeredPolicy(Policy):
    """A frozen diffusion policy and its steering."""

    def __init__(self, base: DiffusionPolicy) -> None:
        """Raises DataError for a policy that cannot be steered."""
        super().__init__(base.spec)
        if base.noise_rows != 1 or base.spec.obs_horizon != 1 or base.spec.denoiser != "items":
            raise DataError("only a policy with --denoiser items and --process flow or ddim can be steered")
        self.base = base.requires_grad_(False)
        self.mean.copy_(base.mean)
        self.scale.copy_(base.scale)
        self.steering = Steering(base.spec, base.spec.horizon * ACTION_WIDTH)

    @property
    def noise_rows(self) -> int:
        return 1

    def steer(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        """Loc and scale (B, N) for observations (B, D)."""
        steered: tuple[Tensor, Tensor] = self.steering(self.normalised(observation))
        return steered

    def chunks(self, observation: Tensor, noise: Tensor) -> Tensor:
        """The imitated policy's chunks (B, H, 5) for observations (B, D) and noise (B, N) as it is."""
        shape = (-1, 1, self.spec.horizon, ACTION_WIDTH)
        made: Tensor = self.base(observation[:, None], noise.reshape(shape))
        return made

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        seen = observation[:, 0]
        loc, scale = self.steer(seen)
        return self.chunks(seen, loc + scale * noise.flatten(1))


class Critic(nn.Module):
    """The expected return (..., 1) of features (..., D)."""

    mean: Tensor
    scale: Tensor

    def __init__(self, policy: Policy) -> None:
        super().__init__()
        self.register_buffer("mean", policy.mean.clone())
        self.register_buffer("scale", policy.scale.clone())
        encoder = ItemEncoder(WIDTH, ITEM_WIDTH, seen=FeatureSet.of(policy.spec))
        self.layers = nn.Sequential(encoder, ResidualBlock(WIDTH), nn.LayerNorm(WIDTH), nn.Linear(WIDTH, 1))

    def forward(self, observation: Tensor) -> Tensor:
        normal = ((observation - self.mean) * self.scale).clamp(-CLIP, CLIP)
        returns: Tensor = self.layers(normal.flatten(0, -2))
        return returns.reshape(*observation.shape[:-1], 1)


def divergence(loc: Tensor, scale: Tensor) -> Tensor:
    """KL (B,) of the steered noise from the standard normal distribution: the length of the leash in use."""
    kl: Tensor = 0.5 * (loc.square() + scale.square() - 1.0 - 2.0 * torch.log(scale)).sum(dim=-1)
    return kl
