"""Grasping as a desired level ("hold") instead of the world's toggle ("press").

Presses occur in about 1 % of ticks: a policy that predicts them has few positive examples, and one wrong sample drops
an item. A level is defined in every tick; the press follows from the level and the state of the hand.
"""

import numpy as np
import numpy.typing as npt

from movingout.world.state import Floats, Ints

Levels = npt.NDArray[np.bool_]


def hold_levels(held: Ints) -> Levels:
    """Desired levels (T, 2) for ticks with hand states `held` (T + 1, 2): whether the hand holds after each tick."""
    levels: Levels = held[1:] >= 0
    return levels


def effective_presses(held: Ints) -> Levels:
    """Presses (T, 2) that changed a hand; presses without effect are dropped (official relabelling)."""
    holding = held >= 0
    changed: Levels = holding[1:] != holding[:-1]
    return changed


def toggles(levels: npt.ArrayLike, holding: bool) -> Floats:
    """Toggles (H,), 0 or 1, that bring a hand to the levels (H,), provided that each press succeeds."""
    wanted = np.asarray(levels, dtype=np.bool_)
    before = np.concatenate(([holding], wanted[:-1]))
    pressed: Floats = (wanted != before).astype(np.float64)
    return pressed
