"""Scores of simulated rollouts: the paper's, or by a learned value."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from movingout.agents.bass.progress import LearnedProgress
from movingout.agents.bass.state_vector import held_of, item_places, robot_places
from movingout.agents.bass.value import Value, ValueQuery
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.world.metrics import normalized_final_distance
from movingout.world.state import Floats

LEARNED = {"value": "value", "tcl": "progress"}  # scores by a network, and what it is called
AC_WEIGHT = 0.05  # weight of action consistency beside NFD; the paper does not give one

Estimator = Value | LearnedProgress
"""What is learned to score states by."""

ScoreFunction = Callable[[Floats, Floats], Floats]
"""Scores (R,) of joint chunks (R, depth, 2, 4) and the states (R, depth, 58) that they lead to."""


def score_function(map_spec: MapSpec, seat: int, spec: SelectionSpec, value: Estimator | None = None) -> ScoreFunction:
    """The score function that `spec` names. Raises AgentError when it needs a value network and there is none."""
    if spec.score in LEARNED and value is None:
        raise AgentError(f"this agent has no {LEARNED[spec.score]} network to choose by; use score=nfd or nfd+ac")
    return lambda joint, predicted: score_rollouts([(map_spec, seat)], [joint], [predicted], spec, value)[0]


def score_rollouts(
    views: Sequence[ValueQuery], joints: Sequence[Floats], predicted: Sequence[Floats], spec: SelectionSpec,
    value: Estimator | None,
) -> list[Floats]:  # fmt: skip
    """Scores (R,) per view, for agents with the same selection."""
    if value is not None and spec.score in LEARNED:
        return value.scores_of(views, [rollouts[:, -1] for rollouts in predicted], spec.depth)
    by = _by_distance if spec.score == "nfd" else _by_distance_and_consistency
    return [by(view[0], joint, rollouts) for view, joint, rollouts in zip(views, joints, predicted, strict=True)]


def _by_distance(map_spec: MapSpec, joint: Floats, predicted: Floats) -> Floats:
    """NFD (R,) of the last states (paper, "Action Selection")."""
    return normalized_final_distance(map_spec, item_places(predicted[:, -1], len(map_spec.items)))


def _by_distance_and_consistency(map_spec: MapSpec, joint: Floats, predicted: Floats) -> Floats:
    """NFD plus weighted action consistency (R,)."""
    return _by_distance(map_spec, joint, predicted) + AC_WEIGHT * _consistency(map_spec, joint, predicted)


def _consistency(map_spec: MapSpec, joint: Floats, predicted: Floats) -> Floats:
    """Action consistency (R,) as `world.metrics` has it: mean of |(f1 + f2) . d| / (|f1| + |f2|), forces f, axis d.

    Only ticks count after which both hands are on one middle or large item and in which somebody pushes; 0 where there
    is none, as nothing is carried together then.
    """
    pushes = joint[..., 0:1] * np.stack((-joint[..., 2], joint[..., 1]), axis=-1)  # (R, depth, 2, 2)
    places = robot_places(predicted)
    line = places[:, :, 1] - places[:, :, 0]
    line /= np.maximum(np.linalg.norm(line, axis=-1, keepdims=True), 1e-6)
    along = np.abs((pushes.sum(axis=2) * line).sum(axis=-1))
    total = np.linalg.norm(pushes, axis=-1).sum(axis=-1)
    counted = _carried_together(map_spec, predicted) & (total > 1e-6)
    terms = np.where(counted, along / np.maximum(total, 1e-6), 0.0)
    consistency: Floats = terms.sum(axis=-1) / np.maximum(counted.sum(axis=-1), 1)
    return consistency


def _carried_together(map_spec: MapSpec, predicted: Floats) -> npt.NDArray[np.bool_]:
    """Whether both hold the same item (R, depth), one that takes two."""
    big = np.array([*(item.size != "small" for item in map_spec.items), False])  # the last one is the empty hand, -1
    held = held_of(predicted.reshape(-1, predicted.shape[-1])).reshape(*predicted.shape[:2], 2)
    together: npt.NDArray[np.bool_] = (held[..., 0] == held[..., 1]) & big[np.minimum(held[..., 0], len(big) - 1)]
    return together
