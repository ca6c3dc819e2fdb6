"""Desired levels and presses are two forms of the same grasping."""

import numpy as np

from movingout.agents.grasp_encoding import effective_presses, hold_levels, toggles


def test_a_press_is_made_exactly_where_the_wanted_level_differs_from_the_hand() -> None:
    assert toggles([True, True, False, True], holding=False).tolist() == [1, 0, 1, 1]
    assert toggles([True, True, False], holding=True).tolist() == [0, 0, 1]


def test_levels_turned_back_into_presses_are_the_presses_that_worked() -> None:
    held = np.array([[-1, 2], [-1, 2], [0, -1], [0, -1], [-1, -1], [3, 1]])
    for seat in (0, 1):
        rebuilt = toggles(hold_levels(held)[:, seat], holding=bool(held[0, seat] >= 0))
        assert np.array_equal(rebuilt > 0, effective_presses(held)[:, seat])
    assert effective_presses(held)[:, 0].tolist() == [False, True, False, True, True]
