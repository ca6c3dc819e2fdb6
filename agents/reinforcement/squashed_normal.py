"""The distribution of a learner's actions, told by what was drawn before tanh brought it into their range."""

import math

import torch
from torch import Tensor
from torch.distributions import Independent, Normal
from torch.nn import functional as F

from movingout.agents.reinforcement.tanh_actor import HIGH, LOW

_STRETCH = torch.tensor([math.log((high - low) / 2.0) for low, high in zip(LOW, HIGH, strict=True)])


class SquashedNormal(Independent[Normal]):
    """Densities of what was drawn (..., 4) before squashing; the entropy is that of the actions.

    PPO takes the ratio of an action's densities, in which the slope of tanh cancels. After squashing it would have to
    be found from actions at the bounds of their range, where single precision has lost what was drawn, and ratios
    become infinite.
    """

    def __init__(self, loc: Tensor, scale: Tensor) -> None:
        super().__init__(Normal(loc, scale), 1)

    def entropy(self) -> Tensor:
        """(...), with the logarithm of tanh's slope estimated from one draw."""
        drawn = self.rsample()
        slope = 2.0 * (math.log(2.0) - drawn - F.softplus(-2.0 * drawn)) + _STRETCH
        total: Tensor = super().entropy() + slope.sum(-1)  # type: ignore[no-untyped-call]
        return total
