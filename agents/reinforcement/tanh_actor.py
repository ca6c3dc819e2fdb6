"""The networks of MAPPO: an actor that both seats share, and a critic that sees what both see."""

import math

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.policies.behaviour_cloning import tanh_layers
from movingout.agents.policies.policy import CLIP, Policy

LOW, HIGH = (-1.0, -1.0, -1.0, 0.0), (1.0, 1.0, 1.0, 1.0)  # distance, cos, sin, grasp
ACTIONS = len(LOW)
_LEAST_SCALE = 1e-4
_BIAS = math.log(math.e - 1.0)  # softplus of it is 1: so wide actions are drawn at first


class TanhActor(Policy):
    """A normal distribution, squashed by tanh into the range of the actions.

    As a policy it draws an action as in training from its noise; with noise of 0 it plays the middle.
    """

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(spec)
        self.head = tanh_layers(spec.features, spec.width, spec.depth, 2 * ACTIONS)
        self.register_buffer("low", torch.tensor(LOW))
        self.register_buffer("high", torch.tensor(HIGH))

    @property
    def noise_rows(self) -> int:
        return 1

    def moments(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        """Location and scale (..., 4) before squashing, for observations (..., D)."""
        loc, raw = self.head(observation.clamp(-CLIP, CLIP)).chunk(2, dim=-1)
        return loc, F.softplus(raw + _BIAS) + _LEAST_SCALE

    def squashed(self, raw: Tensor) -> Tensor:
        """Actions (..., 4) in their range."""
        low, high = self.get_buffer("low"), self.get_buffer("high")
        return low + (high - low) * (torch.tanh(raw) + 1.0) / 2.0

    def forward(self, observation: Tensor, noise: Tensor) -> Tensor:
        """A chunk (B, 1, 5) of one action for observations (B, 1, D), from noise (B, 1, 1, 5)."""
        loc, scale = self.moments(observation)
        action = self.squashed(loc + scale * noise[:, 0, :, :ACTIONS])
        grasp = action[..., 3:]
        return torch.cat((action[..., :3], 1.0 - grasp, grasp), dim=-1)


class CentralCritic(nn.Module):
    """The value of a seat, from what it sees, what the other sees, and how the episode is played."""

    def __init__(self, spec: PolicySpec, modes: int) -> None:
        super().__init__()
        self.head = tanh_layers(2 * spec.features + modes, spec.width, spec.depth, 1)

    def forward(self, state: Tensor) -> Tensor:
        """(..., 1) for states (..., 2 D + modes)."""
        value: Tensor = self.head(state.clamp(-CLIP, CLIP))
        return value
