"""Augmentation by perturbing the partner's pose (paper, "Generating New States by Perturbing the Partner's Pose")."""

import torch
from torch import Tensor

from movingout.world.observation import Layout


def noisy_partner(observation: Tensor, deviation: float, layout: Layout) -> Tensor:
    """Observations (B, To, D) in a layout with the partner's pose, which is perturbed; all else is unchanged.

    x, y [u] and angle [rad] get normal noise with standard deviation `deviation`, the same for all To of a window.
    """
    pose, offset = layout.partner_pose, layout.partner_offset
    assert pose is not None  # `PolicyConfig.check` refuses others
    noisy = observation.clone()
    batch = observation.shape[0]
    shift = deviation * torch.randn(batch, 1, 2, device=observation.device)
    turn = deviation * torch.randn(batch, 1, device=observation.device)
    _, _, cos, sin = observation[..., pose : pose + 4].unbind(-1)
    noisy[..., pose : pose + 2] += shift
    noisy[..., pose + 2] = cos * turn.cos() - sin * turn.sin()
    noisy[..., pose + 3] = sin * turn.cos() + cos * turn.sin()
    if offset is not None:
        noisy[..., offset : offset + 2] += shift
    return noisy
