"""Choosing among candidate chunks by their simulated outcome (paper, "Action Selection").

Knows neither networks nor worlds: chunks and states are arrays, simulator and score function are arguments.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from movingout.agents.bass.score_functions import ScoreFunction
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.world.state import Floats

Simulator = Callable[[Floats], Floats]
"""Predicted moving states (R, depth, 58) of joint chunks (R, depth, 2, 4) in seat order."""


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """The chosen candidate and what it was chosen by."""

    index: int
    scores: Floats  # (own,)
    predicted: Floats  # (R, depth, 58)
    pairs: npt.NDArray[np.intp]  # (R, 2) own and partner candidate of each rollout


def pairs_of(spec: SelectionSpec) -> npt.NDArray[np.intp]:
    """Indices (R, 2) of the own and the partner's candidate in each rollout.

    `independent` pairs candidates by number; `product` takes all combinations.
    """
    if spec.combine == "independent":
        count = max(spec.own, spec.partner)
        return np.stack((np.arange(count) % spec.own, np.arange(count) % spec.partner), axis=1)
    own, partner = np.meshgrid(np.arange(spec.own), np.arange(spec.partner), indexing="ij")
    return np.stack((own.ravel(), partner.ravel()), axis=1)


def choose(
    score_function: ScoreFunction, seat: int, own: Floats, partner: Floats, simulate: Simulator, spec: SelectionSpec
) -> Choice:
    """Choose among own chunks (own, H, 4), given predicted chunks of the partner (partner, H, 4)."""
    joint = joint_chunks(seat, own, partner, spec)
    predicted = simulate(joint)
    return choice_from_scores(score_function(joint, predicted), predicted, spec)


def joint_chunks(seat: int, own: Floats, partner: Floats, spec: SelectionSpec) -> Floats:
    """Joint chunks (R, depth, 2, 4) in seat order, from own chunks (own, H, 4) and the partner's (partner, H, 4)."""
    pairs = pairs_of(spec)
    joint = np.empty((len(pairs), spec.depth, 2, own.shape[-1]))
    joint[:, :, seat] = own[pairs[:, 0], : spec.depth]
    joint[:, :, 1 - seat] = partner[pairs[:, 1], : spec.depth]
    return joint


def choice_from_scores(each: Floats, predicted: Floats, spec: SelectionSpec) -> Choice:
    """The choice, given the score of each rollout (R,) and its predicted states (R, depth, 58).

    A candidate's score is its mean over its rollouts. Of equal candidates the first wins, so that a tie leaves the
    choice to the policy; so does an ensemble, scores (R, members), that disagrees on what is gained (`caution`).
    """
    pairs = pairs_of(spec)
    of_all = np.array([each[pairs[:, 0] == candidate].mean(axis=0) for candidate in range(spec.own)])
    scores = of_all if of_all.ndim == 1 else of_all.mean(axis=1)
    index = int(scores.argmax())
    if of_all.ndim == 2 and spec.caution:
        gains = of_all[index] - of_all[0]
        index = index if gains.mean() > spec.caution * gains.std() else 0
    return Choice(index, scores, predicted, pairs)
