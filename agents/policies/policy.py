"""The policies behind one face: a loss for training, chunks for acting. Normalisation is part of the network."""

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.policies.denoisers import ResMlpDenoiser, UNetDenoiser
from movingout.agents.policies.observers import alike_for_items
from movingout.agents.policies.processes import make_process

MOTION = 3  # the first numbers of an action: distance, cos, sin; the other two are the grasp one-hot
CLIP = 5.0  # normalised features beyond this many standard deviations are cut: a policy must survive a new map


class Policy(nn.Module):
    """Turns observations (B, To, D) into chunks (B, H, 5); the two grasp numbers are compared, the larger one wins."""

    mean: Tensor
    scale: Tensor

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__()
        self.spec = spec
        self.register_buffer("mean", torch.zeros(spec.features))
        self.register_buffer("scale", torch.ones(spec.features))

    def fit_normaliser(self, mean: Tensor, deviation: Tensor) -> None:
        """Take mean and standard deviation (D,) of the training features; constant features are left alone."""
        if self.spec.denoiser == "items":
            mean, deviation = alike_for_items(mean, deviation)
        self.mean.copy_(mean)
        self.scale.copy_(torch.where(deviation > 1e-3, 1.0 / deviation.clamp(min=1e-3), torch.ones_like(deviation)))

    def normalised(self, observation: Tensor) -> Tensor:
        """(B, To, D) to (B, To, D)."""
        return ((observation - self.mean) * self.scale).clamp(-CLIP, CLIP)

    def loss(self, observation: Tensor, chunk: Tensor) -> Tensor:
        """Loss per number, (B, H, 5) or (B, H, 4), to be weighted and averaged by the caller."""
        raise NotImplementedError

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        """A chunk (B, H, 5) for each observation (B, To, D), from noise (B, R, H, 5) (see PolicySpec.noise_rows)."""
        raise NotImplementedError


class _Regression(Policy):
    """Squared error on the motion and cross entropy on the grasp (paper, "Baseline Details")."""

    def predict(self, observation: Tensor) -> Tensor:
        """(B, To, D) normalised to (B, H x 5)."""
        raise NotImplementedError

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        out = self.predict(self.normalised(observation))
        return out.reshape(-1, self.spec.horizon, ACTION_WIDTH)

    def loss(self, observation: Tensor, chunk: Tensor) -> Tensor:
        out = self(observation, chunk)
        motion = (out[..., :MOTION] - chunk[..., :MOTION]) ** 2
        labels = (chunk[..., MOTION + 1] > 0).long()
        grasp = F.cross_entropy(out[..., MOTION:].flatten(0, 1), labels.flatten(), reduction="none")
        return torch.cat((motion, grasp.reshape(*labels.shape, 1)), dim=-1)


def _head(inputs: int, width: int, depth: int, outputs: int) -> nn.Sequential:
    """`depth` fully connected layers with tanh, then a linear one."""
    layers: list[nn.Module] = []
    for layer in range(depth):
        layers += [nn.Linear(inputs if layer == 0 else width, width), nn.Tanh()]
    return nn.Sequential(*layers, nn.Linear(width, outputs))


class MlpPolicy(_Regression):
    """The paper's MLP: past and present observation side by side."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.head = _head(spec.features * spec.obs_horizon, spec.width, spec.depth, spec.horizon * ACTION_WIDTH)

    def predict(self, observation: Tensor) -> Tensor:
        out: Tensor = self.head(observation.flatten(1))
        return out


class GruPolicy(_Regression):
    """The paper's GRU: the observations one after the other, then fully connected layers. It starts from zeros."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.gru = nn.GRU(spec.features, spec.width, batch_first=True)
        self.head = _head(spec.width, spec.width, spec.depth, spec.horizon * ACTION_WIDTH)

    def predict(self, observation: Tensor) -> Tensor:
        hidden, _ = self.gru(observation)
        out: Tensor = self.head(hidden[:, -1])
        return out


class DiffusionPolicy(Policy):
    """Diffusion Policy with the U-Net or the fast denoiser, by diffusion or by flow."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.denoiser = UNetDenoiser(spec) if spec.denoiser == "unet" else ResMlpDenoiser(spec)
        self.process = make_process(spec)

    def _condition(self, observation: Tensor) -> Tensor:
        return self.denoiser.condition(self.normalised(observation).flatten(1))

    def loss(self, observation: Tensor, chunk: Tensor) -> Tensor:
        return self.process.loss(self.denoiser, self._condition(observation), chunk)

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        return self.process.sample(self.denoiser, self._condition(observation), noise)


def build_policy(spec: PolicySpec) -> Policy:
    """The network that a spec describes, with fresh weights."""
    match spec.kind:
        case "mlp":
            return MlpPolicy(spec)
        case "gru":
            return GruPolicy(spec)
        case "dp":
            return DiffusionPolicy(spec)
