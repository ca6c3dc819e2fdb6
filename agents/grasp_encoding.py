"""Grasping as a desired level ("be holding") instead of the world's toggle ("press").

A press happens in one tick of a hundred, so a policy that predicts presses sees almost none, and one wrong sample
undoes what was right. A level is there in every tick, and the press follows from it and from what the hand does.
"""

import numpy as np
import numpy.typing as npt

from movingout.world.state import Floats, Ints

Levels = npt.NDArray[np.bool_]


def hold_levels(held: Ints) -> Levels:
    """Desired levels (T, 2) of ticks that led through `held` (T + 1, 2): the hand after each tick."""
    levels: Levels = held[1:] >= 0
    return levels


def effective_presses(held: Ints) -> Levels:
    """Presses (T, 2) that changed a hand; those that did nothing are not counted (official relabelling)."""
    holding = held >= 0
    changed: Levels = holding[1:] != holding[:-1]
    return changed


def toggles(levels: npt.ArrayLike, holding: bool) -> Floats:
    """Toggles (H,), 0 or 1, that make a hand follow the levels (H,), if each press succeeds."""
    wanted = np.asarray(levels, dtype=np.bool_)
    before = np.concatenate(([holding], wanted[:-1]))
    pressed: Floats = (wanted != before).astype(np.float64)
    return pressed
