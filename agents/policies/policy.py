"""The interface of all policies: a loss for training, chunks for acting. Normalisation is part of the network."""

import torch
from torch import Tensor, nn

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.observation.features import FeatureSet
from movingout.agents.policies.encoders import alike_for_items

MOTION = 3  # the first numbers of an action: distance, cos, sin; the other two are the grasp one-hot
CLIP = 5.0  # standard deviations; normalised features are clipped to it, for maps not seen in training


class Policy(nn.Module):
    """Turns observations (B, To, D) into chunks (B, H, 5); the larger of the two grasp numbers wins."""

    mean: Tensor
    scale: Tensor

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__()
        self.spec = spec
        numbers = 1 if spec.picture else spec.features  # all pixels alike
        self.register_buffer("mean", torch.zeros(numbers))
        self.register_buffer("scale", torch.ones(numbers))

    def fit_normaliser(self, mean: Tensor, deviation: Tensor) -> None:
        """Set the normaliser from mean and standard deviation (D,); constant features are not scaled."""
        if self.spec.denoiser == "items":
            mean, deviation = alike_for_items(mean, deviation, FeatureSet.of(self.spec))
        if self.spec.picture:
            spread = (deviation**2 + (mean - mean.mean()) ** 2).mean().sqrt()
            mean, deviation = mean.mean()[None], spread[None]
        self.mean.copy_(mean)
        self.scale.copy_(torch.where(deviation > 1e-3, 1.0 / deviation.clamp(min=1e-3), torch.ones_like(deviation)))

    def normalised(self, observation: Tensor) -> Tensor:
        """(B, To, D) to (B, To, D)."""
        return ((observation - self.mean) * self.scale).clamp(-CLIP, CLIP)

    @property
    def noise_rows(self) -> int:
        """R: noise tensors (H, 5) that one sample takes; 0 for a policy that draws none."""
        return 0

    def loss(self, observation: Tensor, chunk: Tensor) -> Tensor:
        """Loss per number, (B, H, 5) or (B, H, 4), to be weighted and averaged by the caller."""
        raise NotImplementedError

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        """A chunk (B, H, 5) for each observation (B, To, D), from noise (B, R, H, 5)."""
        raise NotImplementedError
