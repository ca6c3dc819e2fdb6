"""Augmentation by perturbing the partner's pose (paper, "Generating New States by Perturbing the Partner's Pose")."""

import torch
from torch import Tensor

from movingout.world.observation import LAYOUTS, ROBOT_WIDTH

_PARTNER = slice(ROBOT_WIDTH, ROBOT_WIDTH + 4)  # x, y, cos, sin of the partner in every layout
_AWARE_PARTNER = LAYOUTS["map-v1"].size  # the partner's position relative to one's own, in aware-v1


def noisy_partner(observation: Tensor, deviation: float) -> Tensor:
    """Observations (B, To, D) with a perturbed partner pose; all else is unchanged.

    x, y [u] and angle [rad] get normal noise with standard deviation `deviation`, the same for all To of a window.
    """
    noisy = observation.clone()
    batch = observation.shape[0]
    shift = deviation * torch.randn(batch, 1, 2, device=observation.device)
    turn = deviation * torch.randn(batch, 1, device=observation.device)
    _, _, cos, sin = observation[..., _PARTNER].unbind(-1)
    start = _PARTNER.start
    noisy[..., start : start + 2] += shift
    noisy[..., start + 2] = cos * turn.cos() - sin * turn.sin()
    noisy[..., start + 3] = sin * turn.cos() + cos * turn.sin()
    if observation.shape[-1] > _AWARE_PARTNER:
        noisy[..., _AWARE_PARTNER : _AWARE_PARTNER + 2] += shift
    return noisy
