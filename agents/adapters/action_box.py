"""The range of actions that a policy was trained with: ours, or one that `RescaleAction` of Gymnasium maps to ours."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError
from movingout.world.action import POLICY_HIGH, POLICY_LOW
from movingout.world.state import Floats

_LOW, _HIGH = np.array(POLICY_LOW), np.array(POLICY_HIGH)
_USUAL = -1.0, 1.0  # of RescaleAction, as libraries of learning recommend


@dataclass(frozen=True, slots=True)
class ActionBox:
    """One range for all four numbers, to be mapped to ours; None: the actions are ours already."""

    same: tuple[float, float] | None

    def ours(self, action: npt.ArrayLike) -> Floats:
        """Actions (..., 4) of the policy as those of the environments."""
        given = np.asarray(action, dtype=np.float64)
        if self.same is None:
            return given
        low, high = self.same
        scaled: Floats = np.clip(_LOW + (given - low) / (high - low) * (_HIGH - _LOW), _LOW, _HIGH)
        return scaled


def action_box(low: npt.ArrayLike, high: npt.ArrayLike, rescaled: bool | None = None) -> ActionBox:
    """The box with these sides, (4,) each; `rescaled` says whether they are those that `RescaleAction` gave.

    Where nothing says it, only -1 to 1 is taken for them: four equal ranges may be an environment's own as well.
    Raises AgentError for a box whose meaning is not known.
    """
    lows, highs = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if np.array_equal(lows, _LOW) and np.array_equal(highs, _HIGH):
        return ActionBox(None)
    if np.isneginf(lows).all() and np.isposinf(highs).all():  # of ClipAction, which changes no action within ours
        return ActionBox(None)
    one, other = float(lows[0]), float(highs[0])
    if (lows == one).all() and (highs == other).all() and -np.inf < one < other < np.inf:
        if rescaled is None and (one, other) != _USUAL:
            raise AgentError(
                f"the model's actions all go from {one:g} to {other:g}: say rescaled=yes if RescaleAction gave them "
                "this range, or rescaled=no if they mean what they mean in the environments"
            )
        return ActionBox(None if rescaled is False else (one, other))
    raise AgentError(
        f"the model's actions go from {lows.tolist()} to {highs.tolist()}; those of the environments go from "
        f"{list(POLICY_LOW)} to {list(POLICY_HIGH)}, and RescaleAction may give all four another range, such as -1 to 1"
    )
