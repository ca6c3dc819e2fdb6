"""The network over options: each is encoded alone, seen beside the mean and the largest of all, and scored."""

import torch
from torch import Tensor, nn

from movingout.agents.partners.options.features import SIZE
from movingout.agents.partners.options.option import MOST_OPTIONS
from movingout.agents.policies.export import export

NEVER = -1e9  # score of what is not offered


class OptionNetwork(nn.Module):
    """Scores of options, and the value of a situation. The order of options makes no difference."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(SIZE, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh())
        self.head = nn.Sequential(nn.Linear(3 * width, width), nn.Tanh(), nn.Linear(width, 1))
        self.critic = nn.Sequential(nn.Linear(2 * width, width), nn.Tanh(), nn.Linear(width, 1))
        for head, gain in ((self.head[-1], 0.01), (self.critic[-1], 1.0)):
            assert isinstance(head, nn.Linear)
            nn.init.orthogonal_(head.weight, gain)

    def forward(self, options: Tensor, offered: Tensor) -> Tensor:
        """Scores (B, K) of options (B, K, SIZE), where `offered` (B, K) is 1; NEVER elsewhere."""
        each, all_of_them = self._encoded(options, offered)
        beside = all_of_them[:, None, :].expand(-1, options.shape[1], -1)
        scores = self.head(torch.cat((each, beside), dim=-1)).squeeze(-1)
        return torch.where(offered > 0.5, scores, torch.full_like(scores, NEVER))

    def value(self, options: Tensor, offered: Tensor) -> Tensor:
        """(B, 1): the discounted reward that is expected."""
        value: Tensor = self.critic(self._encoded(options, offered)[1])
        return value

    def _encoded(self, options: Tensor, offered: Tensor) -> tuple[Tensor, Tensor]:
        """Each option (B, K, W), and all of them (B, 2 W)."""
        there = offered[..., None]
        each = self.encoder(options) * there
        mean = each.sum(dim=1) / there.sum(dim=1).clamp(min=1.0)
        largest = (each - 2.0 * (1.0 - there)).amax(dim=1)
        return each, torch.cat((mean, largest), dim=-1)


def export_options(network: OptionNetwork) -> bytes:
    """ONNX of `options` (B, K, SIZE) and `offered` (B, K) to `scores` (B, K)."""
    example = torch.zeros(2, MOST_OPTIONS, SIZE), torch.ones(2, MOST_OPTIONS)
    inputs = {
        "options": "per option the numbers of agents/partners/options/features.py",
        "offered": "1 where there is an option, else 0",
    }
    outputs = {"scores": "per option the logarithm of its probability, but for a constant"}
    return export(network, example, inputs, outputs, {"network": "options"})
