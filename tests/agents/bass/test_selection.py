"""Which candidate is chosen, given what a simulator says."""

import numpy as np
import pytest

from movingout.agents.bass.score_functions import AC_WEIGHT, score_function
from movingout.agents.bass.selection import choice_from_scores, choose, pairs_of
from movingout.agents.bass.state_vector import (
    HELD_START,
    HELD_WIDTH,
    ITEMS_START,
    item_places,
    moving,
    moving_arrays,
    robot_places,
)
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.maps import load_map
from movingout.world.observation import ITEM_SLOTS
from movingout.world.state import Floats
from tests.agents.learning import states_of, walked

MAP = load_map("DistancePriority")
BIG, SMALL = (next(k for k, item in enumerate(MAP.items) if (item.size == "small") is small) for small in (False, True))
START = moving(states_of(MAP, np.zeros((0, 2, 3)))[0])


def _chunks(distances: list[float]) -> Floats:
    chunks = np.zeros((len(distances), 8, 4))
    chunks[..., 0] = np.array(distances)[:, None]
    chunks[..., 1] = 1.0
    return chunks


def _item_follows_both(joint: Floats) -> Floats:
    """A world in which item 0 moves by the product of what both do: towards the goal when it is positive."""
    predicted = np.tile(START, (*joint.shape[:2], 1))
    start = item_places(START, 4)[0]
    goal = np.array([(MAP.goals[0].left + MAP.goals[0].right) / 2, (MAP.goals[0].bottom + MAP.goals[0].top) / 2])
    moved = start + (goal - start) * 0.5 * (joint[:, :, 0, :1] * joint[:, :, 1, :1])
    predicted[..., ITEMS_START : ITEMS_START + 2] = moved
    return predicted


@pytest.mark.parametrize("seat", [0, 1])
def test_the_candidate_that_brings_the_items_nearest_to_the_goal_is_chosen(seat: int) -> None:
    spec = SelectionSpec(own=3, partner=2, combine="product", depth=4)
    choice = choose(
        score_function(MAP, seat, spec), seat, _chunks([-1.0, 1.0, 0.2]), _chunks([0.5, 1.0]), _item_follows_both, spec
    )
    assert choice.index == 1
    assert choice.scores[1] > choice.scores[2] > choice.scores[0]
    assert choice.predicted.shape == (6, 4, 58)


def test_what_the_partner_is_expected_to_do_decides() -> None:
    spec = SelectionSpec(own=2, partner=2, combine="product", depth=4)
    assert (
        choose(
            score_function(MAP, 0, spec), 0, _chunks([-1.0, 1.0]), _chunks([-1.0, -1.0]), _item_follows_both, spec
        ).index
        == 0
    )


def test_where_nothing_tells_candidates_apart_the_first_is_taken() -> None:
    spec = SelectionSpec(own=4, partner=4, depth=8)
    choice = choose(
        score_function(MAP, 0, spec),
        0,
        _chunks([0.1, 0.2, 0.3, 0.4]),
        _chunks([0.0] * 4),
        lambda joint: np.tile(START, (16, 8, 1)),
        spec,
    )
    assert choice.index == 0 and np.ptp(choice.scores) == 0


def test_pairs_are_each_with_each_or_one_with_one() -> None:
    assert len(pairs_of(SelectionSpec(own=4, partner=4, combine="product"))) == 16
    assert pairs_of(SelectionSpec(own=4, partner=4, combine="independent")).tolist() == [[k, k] for k in range(4)]
    assert len(pairs_of(SelectionSpec(own=2, partner=2, combine="product"))) == 4


def _scores_of_pushing_along_and_against(held: tuple[int, int]) -> Floats:
    """Scores of two own candidates, the first against the partner's push; red stands above blue, both push that way."""
    spec = SelectionSpec(own=2, partner=1, combine="product", score="nfd+ac", depth=8)
    own = _chunks([1.0, 1.0])
    own[0, :, 1:3] = -1.0, 0.0
    still = np.tile(START, (2, 8, 1))
    still[..., 7:9] = still[..., 0:2] + (0.0, 0.4)
    hands = np.eye(HELD_WIDTH)[[ITEM_SLOTS if item < 0 else item for item in held]]
    still[..., HELD_START:ITEMS_START] = hands.ravel()
    return choose(score_function(MAP, 0, spec), 0, own, _chunks([1.0]), lambda joint: still, spec).scores


def test_pulling_together_counts_with_the_second_score() -> None:
    against, along = _scores_of_pushing_along_and_against((BIG, BIG))
    assert along - against == pytest.approx(AC_WEIGHT)


@pytest.mark.parametrize("held", [(-1, -1), (BIG, -1), (SMALL, SMALL)])
def test_pushing_alike_counts_for_nothing_where_nothing_big_is_carried_together(held: tuple[int, int]) -> None:
    against, along = _scores_of_pushing_along_and_against(held)
    assert along == against


def test_the_moving_row_says_where_robots_and_items_are_and_what_is_held() -> None:
    trajectory = walked("DistancePriority", ticks=10)
    held = trajectory.held.copy()
    held[4] = 3, -1
    rows = moving_arrays(trajectory.robot_poses, trajectory.robot_velocities, held, trajectory.item_poses)
    assert np.array_equal(robot_places(rows), trajectory.robot_poses[..., :2])
    assert np.array_equal(item_places(rows, 4), trajectory.item_poses[..., :2])
    assert np.flatnonzero(rows[4, 14:30]).tolist() == [3, 15]


def test_an_ensemble_that_disagrees_leaves_the_choice_to_the_policy() -> None:
    spec = SelectionSpec(own=2, partner=1, combine="product", score="value", caution=1.0)
    predicted = np.zeros((2, 8, 58))
    agreed = np.array([[0.1, 0.1, 0.1], [0.2, 0.21, 0.19]])  # (R, members)
    assert choice_from_scores(agreed, predicted, spec).index == 1
    torn = np.array([[0.1, 0.1, 0.1], [0.5, 0.0, 0.0]])
    choice = choice_from_scores(torn, predicted, spec)
    assert choice.index == 0 and np.allclose(choice.scores, [0.1, 0.5 / 3])
    assert choice_from_scores(torn, predicted, spec.model_copy(update={"caution": 0.0})).index == 1
