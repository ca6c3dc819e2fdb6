"""Augmentation of features in the own frame: exact mirror images, and memories in which nothing has changed."""

import torch
from torch import Tensor, nn

from movingout.agents.observation.features import FeatureSet

_SIN = 2  # index of an action's sideways component


class OwnFrameAugmentation(nn.Module):
    """Mirrors a share of the windows, and makes a share of them forget."""

    order: Tensor
    signs: Tensor
    present: Tensor
    kept: Tensor

    def __init__(self, seen: FeatureSet, mirrored: float, forgotten: float) -> None:
        """For features with a mirror."""
        super().__init__()
        mirror = seen.mirror
        assert mirror is not None
        self.mirrored, self.forgotten = mirrored, forgotten
        self.register_buffer("order", torch.from_numpy(mirror[0]))
        self.register_buffer("signs", torch.from_numpy(mirror[1]).float())
        sources, kept = seen.unchanged
        self.register_buffer("present", torch.from_numpy(sources))
        self.register_buffer("kept", torch.from_numpy(kept).float())

    def forward(self, observation: Tensor, chunk: Tensor) -> tuple[Tensor, Tensor]:
        """Observations (B, To, D) and chunks (B, H, 5), changed alike."""
        count = len(observation)
        if self.forgotten:
            forgets = torch.rand(count, 1, 1, device=observation.device) < self.forgotten
            observation = torch.where(forgets, _taken(observation, self.present) * self.kept, observation)
        flips = torch.rand(count, 1, 1, device=observation.device) < self.mirrored
        return self.mirror(observation, chunk, flips)

    def mirrored_rows(self, features: Tensor) -> Tensor:
        """A share of the rows (..., D) mirrored, on the device of the rows."""
        order, signs = self.order.to(features.device), self.signs.to(features.device)
        flips = torch.rand(*features.shape[:-1], 1, device=features.device) < self.mirrored
        return torch.where(flips, _taken(features, order) * signs, features)

    def mirror(self, observation: Tensor, chunk: Tensor, flips: Tensor) -> tuple[Tensor, Tensor]:
        """Mirrored where `flips` (B, 1, 1) says so."""
        other = chunk.clone()
        other[..., _SIN] *= -1.0
        seen = torch.where(flips, _taken(observation, self.order) * self.signs, observation)
        return seen, torch.where(flips, other, chunk)


def _taken(rows: Tensor, columns: Tensor) -> Tensor:
    """`rows[..., columns]`, which takes a CPU five times as long."""
    return rows.gather(-1, columns.expand(*rows.shape[:-1], len(columns)))
