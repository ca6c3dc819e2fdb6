"""Networks that encode an observation, once per decision, as the condition of a denoiser."""

import math

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.observation.features import FeatureSet
from movingout.world.observation import AWARE_LAYOUT

HEADS = 4  # the width of an item is a multiple of it
AWARE = FeatureSet(AWARE_LAYOUT)


class ResidualBlock(nn.Module):
    """Two layers with a residual connection, on vectors (..., W)."""

    def __init__(self, width: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.LayerNorm(width),
            nn.Linear(width, width),
            nn.SiLU(),
            nn.Dropout(dropout),
            nn.Linear(width, width),
        )

    def forward(self, hidden: Tensor) -> Tensor:
        out: Tensor = hidden + self.layers(hidden)
        return out


class FlatEncoder(nn.Sequential):
    """All features in one vector; nothing is shared between item slots."""

    def __init__(self, spec: PolicySpec) -> None:
        super().__init__(
            nn.Linear(spec.features * spec.obs_horizon, spec.width),
            nn.SiLU(),
            ResidualBlock(spec.width, spec.dropout),
        )


class ItemEncoder(nn.Module):
    """Encodes each item with shared weights, lets items attend to each other, and pools them by attention.

    The result does not depend on the order of the items, and every episode trains the same weights for all of them.
    """

    item_columns: Tensor
    other_columns: Tensor

    def __init__(
        self, width: int, item_width: int, ticks: int = 1, dropout: float = 0.0, seen: FeatureSet = AWARE
    ) -> None:
        """For `ticks` concatenated observations; `item_width` is the size of an item embedding."""
        super().__init__()
        items, others = columns(ticks, seen)
        self.register_buffer("item_columns", items.flatten(), persistent=False)
        self.register_buffer("other_columns", others, persistent=False)
        self.slots, per_item = items.shape
        self.width = item_width
        self.item = nn.Linear(per_item, item_width)
        self.around = nn.Linear(len(others), item_width)
        self.alone = ResidualBlock(item_width, dropout)
        self.norm = nn.LayerNorm(item_width)
        self.asks = nn.Linear(item_width, 3 * item_width)
        self.learns = nn.Linear(item_width, item_width)
        self.together = ResidualBlock(item_width, dropout)
        self.weights = nn.Linear(item_width, 2 * HEADS)
        self.values = nn.Linear(item_width, 2 * item_width)
        self.summed = nn.Linear(3 * item_width, width)
        self.whole = nn.Linear(len(others), width)
        self.last = ResidualBlock(width, dropout)

    def forward(self, observation: Tensor) -> Tensor:
        """(B, To x D) to (B, W)."""
        others = observation[:, self.other_columns]
        items = observation[:, self.item_columns].reshape(-1, self.slots, self.item.in_features)
        hidden = self.alone(F.silu(self.item(items) + self.around(others)[:, None]))
        hidden = self.together(hidden + self.learns(self._attend(self.norm(hidden))))
        weights = self.weights(hidden).softmax(dim=1)[..., None]  # (B, N, 8, 1)
        values = self.values(hidden).reshape(-1, self.slots, 2 * HEADS, self.width // HEADS)
        told = torch.cat(((weights * values).sum(dim=1).flatten(1), hidden.amax(dim=1)), dim=1)
        out: Tensor = self.last(F.silu(self.whole(others) + self.summed(told)))
        return out

    def _attend(self, hidden: Tensor) -> Tensor:
        """Multi-head self-attention among items (B, N, W)."""
        size = self.width // HEADS
        query, key, value = self.asks(hidden).reshape(-1, self.slots, 3, HEADS, size).permute(2, 0, 3, 1, 4)
        regard = (query @ key.transpose(-1, -2) / math.sqrt(size)).softmax(dim=-1)
        seen: Tensor = (regard @ value).transpose(1, 2).reshape(-1, self.slots, self.width)
        return seen


def columns(ticks: int, seen: FeatureSet = AWARE) -> tuple[Tensor, Tensor]:
    """Of To x D features, the indices of each item's (N, K), and of those that belong to no item (L,)."""
    size, of_items = seen.size, torch.from_numpy(seen.items)
    items = torch.cat([of_items + size * tick for tick in range(ticks)], dim=1)
    about_items = set(items.flatten().tolist())
    return items, torch.tensor([column for column in range(size * ticks) if column not in about_items])


def alike_for_items(mean: Tensor, deviation: Tensor, seen: FeatureSet = AWARE) -> tuple[Tensor, Tensor]:
    """Mean and standard deviation (D,) of features, pooled over item slots."""
    slots = torch.from_numpy(seen.items)
    means, variances = mean[slots], deviation[slots] ** 2
    common = means.mean(dim=0)
    spread = (variances + (means - common) ** 2).mean(dim=0).sqrt()
    mean, deviation = mean.clone(), deviation.clone()
    mean[slots], deviation[slots] = common.expand_as(means), spread.expand_as(means)
    return mean, deviation
