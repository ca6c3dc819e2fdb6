"""The simulator and the progress of BASS for policies that see pictures, as networks that are exported whole."""

import torch
from torch import Tensor, nn

from movingout.agents.bass.latent.dynamics import LatentDynamics
from movingout.agents.bass.state_vector import ACTION_WIDTH
from movingout.agents.checkpoint.card import DynamicsSpec, ProgressSpec
from movingout.agents.policies.pictures import LEVEL, ConvolutionalDecoder, ConvolutionalEncoder, as_numbers

Shape = tuple[int, int, int]


class PictureDynamics(nn.Module):
    """The picture (B, D) that an agent will see after joint chunks (B, depth, 2, 4), its own first."""

    def __init__(self, spec: DynamicsSpec, shape: Shape) -> None:
        super().__init__()
        self.spec, self.shape = spec, shape
        self.model = LatentDynamics(
            lambda size: ConvolutionalEncoder(shape, 1, size),
            lambda: ConvolutionalDecoder(shape, spec.latent),
            2 * ACTION_WIDTH, spec.width, spec.latent, residual=spec.residual,
        )  # fmt: skip

    def forward(self, picture: Tensor, actions: Tensor) -> Tensor:
        drawn: Tensor = self.model(as_numbers(picture), actions.flatten(2)).clamp(0.0, 1.0) * LEVEL
        return drawn

    def losses(self, picture: Tensor, actions: Tensor, after: Tensor) -> dict[str, Tensor]:
        return self.model.losses(as_numbers(picture), actions.flatten(2), as_numbers(after))


class PictureProgress(nn.Module):
    """The embedding (B, Z) of pictures (B, D) whose distance from that of the start stands for progress."""

    def __init__(self, spec: ProgressSpec, shape: Shape) -> None:
        super().__init__()
        self.spec, self.shape = spec, shape
        self.layers = nn.Sequential(
            ConvolutionalEncoder(shape, 1, spec.width), nn.ReLU(), nn.Linear(spec.width, spec.latent)
        )

    def forward(self, picture: Tensor) -> Tensor:
        embedded: Tensor = self.layers(as_numbers(picture))
        return embedded


def example_picture(shape: Shape, count: int = 2) -> Tensor:
    """For the export of these networks."""
    height, breadth, colours = shape
    return torch.zeros(count, height * breadth * colours)
