"""Behaviour cloning by regression: the paper's MLP and GRU ("Baseline Details").

The network predicts the whole chunk at once. Its loss is the squared error of the motion and the cross entropy of the
grasp; to act, it is simply evaluated.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.policies.policy import MOTION, Policy


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


def tanh_layers(inputs: int, width: int, depth: int, outputs: int) -> nn.Sequential:
    """The paper's MLP: `depth` layers of `width` units with tanh, and a linear one."""
    layers: list[nn.Module] = []
    for layer in range(depth):
        layers += [nn.Linear(inputs if layer == 0 else width, width), nn.Tanh()]
    return nn.Sequential(*layers, nn.Linear(width, outputs))


class MlpPolicy(_Regression):
    """The paper's MLP: past and present observation side by side."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.head = tanh_layers(spec.features * spec.obs_horizon, spec.width, spec.depth, spec.horizon * ACTION_WIDTH)

    def predict(self, observation: Tensor) -> Tensor:
        out: Tensor = self.head(observation.flatten(1))
        return out


class GruPolicy(_Regression):
    """The paper's GRU: the observations one after the other, then fully connected layers. It starts from zeros."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.gru = nn.GRU(spec.features, spec.width, batch_first=True)
        self.head = tanh_layers(spec.width, spec.width, spec.depth, spec.horizon * ACTION_WIDTH)

    def predict(self, observation: Tensor) -> Tensor:
        hidden, _ = self.gru(observation)
        out: Tensor = self.head(hidden[:, -1])
        return out
