"""The effect of a press in the learned simulator: a full hand lets go, an empty one takes an item within reach.

Hands change in about 1 % of ticks. A network that predicts whole states with one loss learns that they never do: it
predicted none of 342 changes (2026-11-22), and simulating with it does not distinguish a candidate that takes an item
from one that does not. Reach follows from the game's rule and geometry, so it is computed.
"""

import numpy as np
import torch
from torch import Tensor, nn

from movingout.agents.bass.state_vector import (
    HELD_START,
    HELD_WIDTH,
    ITEM_CONSTANTS,
    ITEMS_START,
    ROBOT_WIDTH,
    TURN_UNIT,
)
from movingout.maps.shapes import corner_radius
from movingout.maps.spec import SHAPES, SIZES
from movingout.maps.surface import polygon
from movingout.world import constants as c
from movingout.world.observation import ITEM_SLOTS

_FAR = 10.0  # [u] where items are that do not exist, or cannot be taken
_SHAPE = slice(1, 1 + len(SHAPES))  # where these stand in the constants of an item
_SMALL = 1 + len(SHAPES) + SIZES.index("small")
_SCALE = ITEM_CONSTANTS - 2


class Grasping(nn.Module):
    """What both hands hold after a tick. Nothing in it is learned."""

    starts_x: Tensor  # (8, V) vertices of each shape at scale 1
    starts_y: Tensor
    edges_x: Tensor  # (8, V) that begin there
    edges_y: Tensor
    radii: Tensor  # (8, 1) how far the surface is outside of them

    def __init__(self) -> None:
        super().__init__()
        outlines = [_outline(shape) for shape in SHAPES]
        longest = max(len(starts) for starts, _ in outlines)
        padded = [[np.pad(part, ((0, longest - len(part)), (0, 0)), "edge") for part in both] for both in outlines]
        for name, rows in zip(("starts", "edges"), zip(*padded, strict=True), strict=True):
            # x and y apart: sums over an axis of two cost a third of the simulator's time
            for axis, values in zip("xy", np.moveaxis(np.array(rows), -1, 0), strict=True):
                self.register_buffer(f"{name}_{axis}", torch.tensor(values, dtype=torch.float32), persistent=False)
        radii = [1.0 if shape == "circle" else corner_radius(shape, 1.0) for shape in SHAPES]
        self.register_buffer("radii", torch.tensor(radii)[:, None], persistent=False)

    def forward(self, state: Tensor, constant: Tensor, press: Tensor) -> Tensor:
        """Hands (B, 2, 8), one-hot, after states (B, 58) of maps (B, 146) with presses (B, 2), 1 or 0.

        Blue's hand acts at the start of a tick, red's in the middle, and red drives as before until then. Red does not
        see yet what blue's press does to a small item in the same tick.
        """
        hands = hands_of(state)
        blue, red = state[:, :HELD_START].reshape(-1, 2, ROBOT_WIDTH).unbind(1)
        gaps = self.gaps(torch.stack((blue, _coasted(red)), dim=1), state, constant)
        nearest = -(-gaps).amax(dim=-1, keepdim=True)
        takes = ((nearest >= gaps) & (gaps < c.REACH_TOLERANCE)).to(state.dtype)  # (B, 2, 7)
        nothing = 1.0 - takes.amax(dim=-1, keepdim=True)
        empty = hands[..., -1:]
        pressed = torch.cat((empty * takes, empty * nothing + 1.0 - empty), dim=-1)
        return torch.where(press[..., None] > 0.5, pressed, hands)

    def gaps(self, robots: Tensor, state: Tensor, constant: Tensor) -> Tensor:
        """(B, 2, 7) [u] from what robots (B, 2, 7) reach out with to the surface of each item that they could take."""
        about = constant[:, : ITEM_SLOTS * ITEM_CONSTANTS].reshape(-1, ITEM_SLOTS, ITEM_CONSTANTS)
        items = state[:, ITEMS_START:].reshape(-1, 1, ITEM_SLOTS, 4)
        scale = about[..., _SCALE].clamp(min=1e-3)[:, None]  # (B, 1, 7)
        probe_x = (robots[..., 0] - c.REACH * robots[..., 3])[..., None] - items[..., 0]  # (B, 2, 7)
        probe_y = (robots[..., 1] + c.REACH * robots[..., 2])[..., None] - items[..., 1]
        cos, sin = items[..., 2], items[..., 3]
        x, y = (cos * probe_x + sin * probe_y) / scale, (cos * probe_y - sin * probe_x) / scale
        shape = about[..., _SHAPE]
        gaps = (self._outside(x, y, shape) - (shape @ self.radii)[:, None, :, 0]) * scale
        taken = hands_of(state)[:, :, :-1].flip(1) * about[:, None, :, _SMALL]  # small ones are for one hand
        return torch.where((about[:, None, :, 0] > 0.5) & (taken < 0.5), gaps, torch.full_like(gaps, _FAR))

    def _outside(self, x: Tensor, y: Tensor, shape: Tensor) -> Tensor:
        """Distances (B, 2, 7) of points in the frames of items of scale 1 to the edges of their shapes (B, 7, 8)."""
        starts_x, starts_y, edges_x, edges_y = (
            (shape @ rows)[:, None] for rows in (self.starts_x, self.starts_y, self.edges_x, self.edges_y)
        )
        dx, dy = x[..., None] - starts_x, y[..., None] - starts_y  # (B, 2, 7, V)
        lengths = (edges_x * edges_x + edges_y * edges_y).clamp(min=1e-9)
        along = ((dx * edges_x + dy * edges_y) / lengths).clamp(0.0, 1.0)
        dx, dy = dx - along * edges_x, dy - along * edges_y
        return (-(-(dx * dx + dy * dy)).amax(dim=-1)).sqrt()


def hands_of(state: Tensor) -> Tensor:
    """(B, 2, 8) what both hands hold in moving states (B, 58), one-hot, the last for an empty hand."""
    return state[:, HELD_START:ITEMS_START].reshape(-1, 2, HELD_WIDTH)


def _outline(shape: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 2) of an item of scale 1 and the edges that begin there; a circle is a point with a wide border."""
    return (np.zeros((1, 2)), np.zeros((1, 2))) if shape == "circle" else polygon(shape, 1.0)


def _coasted(robots: Tensor) -> Tensor:
    """Robots (B, 7) half a tick later, as they are moving now."""
    turn = robots[:, 6:] * (TURN_UNIT * c.HALF_TICK_SECONDS)
    cos, sin = robots[:, 2:3], robots[:, 3:4]
    facing = torch.cat((cos * turn.cos() - sin * turn.sin(), sin * turn.cos() + cos * turn.sin()), dim=-1)
    return torch.cat((robots[:, :2] + c.HALF_TICK_SECONDS * robots[:, 4:6], facing, robots[:, 4:]), dim=-1)
