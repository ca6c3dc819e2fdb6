"""Choosing by what is done and what will follow."""

import numpy as np
import pytest

from movingout.agents.bass.score_functions import score_function
from movingout.agents.bass.state_vector import moving_arrays, states_of
from movingout.agents.bass.value import Value, progress
from movingout.agents.checkpoint.card import SelectionSpec, ValueSpec
from movingout.agents.errors import AgentError
from movingout.maps import load_map
from movingout.world.metrics import normalized_final_distance, task_completion_rate
from movingout.world.state import Floats
from tests.agents.learning import walked

MAP = load_map("DistancePriority")
COUNT = len(MAP.items)


class _Constant:
    """A network that expects the same of every state."""

    def __init__(self, value: float) -> None:
        self.value = value

    def __call__(self, features: Floats) -> list[Floats]:
        assert features.dtype == np.float32
        return [np.full(len(features), self.value)]


def test_states_come_back_from_the_rows_that_simulators_use() -> None:
    trajectory = walked("DistancePriority", ticks=30, seed=3)
    arrays = trajectory.state_arrays
    poses, velocities, held, items = states_of(moving_arrays(*arrays), COUNT)
    assert np.allclose(poses[..., :2], trajectory.robot_poses[..., :2]) and np.allclose(
        velocities, trajectory.robot_velocities
    )
    assert np.array_equal(held, trajectory.held)
    for angles, expected in (
        (poses[..., 2], trajectory.robot_poses[..., 2]),
        (items[..., 2], trajectory.item_poses[..., 2]),
    ):
        assert np.allclose(np.cos(angles), np.cos(expected)) and np.allclose(np.sin(angles), np.sin(expected))
    assert np.allclose(items[..., :2], trajectory.item_poses[..., :2])


def test_progress_is_the_mean_of_distance_and_completion() -> None:
    trajectory = walked("DistancePriority", ticks=3)
    delivered = np.zeros((4, 7))
    delivered[2, 0] = 1.0
    done = progress(MAP, trajectory.item_poses, delivered)
    nfd = normalized_final_distance(MAP, trajectory.item_poses)
    assert np.allclose(done[[0, 1, 3]], nfd[[0, 1, 3]] / 2)
    tcr = task_completion_rate(MAP, delivered[2, :COUNT].astype(bool))
    assert tcr > 0 and done[2] == pytest.approx((nfd[2] + tcr) / 2)


def test_what_follows_counts_less_the_deeper_the_simulation() -> None:
    trajectory = walked("DistancePriority", ticks=5)
    rows = moving_arrays(*trajectory.state_arrays)
    nothing, much = (Value(ValueSpec(discount=0.9), _Constant(value)) for value in (0.0, 1.0))  # type: ignore[arg-type]
    for depth in (2, 8):
        (more,), (less,) = (value.scores_of([(MAP, 0)], [rows], depth) for value in (much, nothing))
        assert np.allclose(more - less, 0.9**depth)


def test_who_looks_together_sees_what_each_sees_alone() -> None:
    """Also when maps and seats alternate and the numbers of states differ."""
    looks = []
    for name, seat, ticks in (("HandOff", 0, 3), ("LeftRight", 1, 5), ("HandOff", 0, 4), ("HandOff", 1, 2)):
        trajectory = walked(name, ticks=ticks, seed=ticks)
        rows = moving_arrays(
            trajectory.robot_poses, trajectory.robot_velocities, trajectory.held, trajectory.item_poses
        )
        looks.append(((load_map(name), seat), rows))
    value = Value(ValueSpec(), lambda features: [features.sum(axis=1)])  # type: ignore[arg-type]
    together = value.scores_of([view for view, _ in looks], [rows for _, rows in looks], 8)
    for (view, rows), found in zip(looks, together, strict=True):
        (alone,) = value.scores_of([view], [rows], 8)
        assert np.allclose(found, alone, rtol=1e-6) and len(found) == len(rows)


def test_choosing_by_a_value_that_is_not_there_is_refused() -> None:
    with pytest.raises(AgentError, match="no value network"):
        score_function(MAP, 0, SelectionSpec(score="value"))
