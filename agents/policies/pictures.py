"""Networks for pictures: a small CNN that encodes them, and its mirror image that draws them.

Four convolutions of stride 2 or 4 bring 128 x 128 pixels down to 4 x 4 places of 64 numbers, about 4 MFLOP a picture,
so that a decision fits into a tick on one core. The places are not pooled: where something is matters.
"""

from itertools import pairwise

import torch
from torch import Tensor, nn

CHANNELS = (16, 32, 64, 64)
SHRUNK = 32  # how many pixels a place is wide at the end
LEVEL = 255.0


class ConvolutionalEncoder(nn.Module):
    """Pictures of bytes or normalised numbers, flat (B, To x D), to (B, W)."""

    def __init__(self, shape: tuple[int, int, int], pictures: int, width: int) -> None:
        """For `pictures` consecutive pictures of (height, width, colours), which become channels."""
        super().__init__()
        self.shape, self.pictures = shape, pictures
        height, breadth, colours = shape
        first, second, third, fourth = CHANNELS
        self.layers = nn.Sequential(
            nn.Conv2d(pictures * colours, first, 5, stride=4, padding=2),
            nn.SiLU(),
            nn.Conv2d(first, second, 3, stride=2, padding=1),
            nn.SiLU(),
            nn.Conv2d(second, third, 3, stride=2, padding=1),
            nn.SiLU(),
            nn.Conv2d(third, fourth, 3, stride=2, padding=1),
            nn.SiLU(),
            nn.Flatten(),
            nn.Linear(fourth * (height // SHRUNK) * (breadth // SHRUNK), width),
        )

    def forward(self, observation: Tensor) -> Tensor:
        height, breadth, colours = self.shape
        seen = observation.reshape(-1, self.pictures, height, breadth, colours).permute(0, 1, 4, 2, 3)
        out: Tensor = self.layers(seen.reshape(-1, self.pictures * colours, height, breadth))
        return out


class ConvolutionalDecoder(nn.Module):
    """A latent (B, Z) to a flat picture (B, D) with numbers around 0 to 1."""

    def __init__(self, shape: tuple[int, int, int], latent: int) -> None:
        super().__init__()
        self.shape = shape
        self.places = shape[0] // SHRUNK, shape[1] // SHRUNK
        self.enter = nn.Linear(latent, CHANNELS[3] * self.places[0] * self.places[1])
        sizes = (CHANNELS[3], 32, 32, 16, 8)
        grow = [
            layer
            for before, after in pairwise(sizes)
            for layer in (nn.ConvTranspose2d(before, after, 4, stride=2, padding=1), nn.SiLU())
        ]
        self.layers = nn.Sequential(nn.SiLU(), *grow, nn.ConvTranspose2d(sizes[-1], shape[2], 4, stride=2, padding=1))

    def forward(self, latent: Tensor) -> Tensor:
        hidden = self.enter(latent).reshape(-1, CHANNELS[3], *self.places)
        drawn: Tensor = self.layers(hidden).permute(0, 2, 3, 1).flatten(1)
        return drawn


def as_numbers(pictures: Tensor) -> Tensor:
    """Pictures (B, D) with 0 to 255 as numbers from 0 to 1."""
    return pictures.to(torch.float32) / LEVEL
