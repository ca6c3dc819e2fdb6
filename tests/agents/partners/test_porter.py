"""The stubborn porter keeps to its order, its goal and its item."""

import math
from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.porter import PATIENCE, PATIENCE_LIGHT, StubbornPorter
from movingout.agents.partners.walking import goal_centres
from movingout.maps import load_map
from tests.agents.partners.scenes import asked, heading, holding, presses_after, seated


def test_it_holds_a_heavy_item_for_half_a_minute_and_a_small_one_less_long() -> None:
    heavy = presses_after(
        seated(StubbornPorter(), "SingleRotation"), "SingleRotation", holding("SingleRotation", 0), 400
    )
    light = presses_after(seated(StubbornPorter(), "PassOrSplit"), "PassOrSplit", holding("PassOrSplit", 0), 400)
    assert (heavy, light) == (PATIENCE + 1, PATIENCE_LIGHT + 1)


def test_it_pulls_straight_to_the_goal_that_it_chose_even_when_another_has_become_nearer() -> None:
    the_map, state = load_map("FourCorners"), holding("FourCorners", 0)
    agent = seated(StubbornPorter(), "FourCorners")
    first = heading(asked(agent, "FourCorners", state))
    x, y = state.item_poses[0, :2].tolist()
    chosen = min(goal_centres(the_map), key=lambda goal: math.dist(goal, (x, y)))
    other = max(goal_centres(the_map), key=lambda goal: math.dist(goal, chosen))
    moved = state.item_poses.copy()
    moved[0, :2] = 0.7 * np.array(other) + 0.3 * np.array(chosen)
    second = heading(asked(agent, "FourCorners", replace(state, tick=1, item_poses=moved)))
    for seen, place in ((first, (x, y)), (second, moved[0, :2].tolist())):
        straight = math.atan2(-(chosen[0] - place[0]), chosen[1] - place[1])
        assert math.cos(seen - straight) == pytest.approx(1.0)


def test_its_order_follows_from_its_seed_and_is_not_that_of_another() -> None:
    orders = set()
    for seed in range(6):
        agent = seated(StubbornPorter(seed), "PriorityPick")
        assert isinstance(agent, StubbornPorter)
        orders.add(tuple(agent._order))
        again = seated(StubbornPorter(seed), "PriorityPick")
        assert isinstance(again, StubbornPorter) and again._order == agent._order
    assert len(orders) > 3


def test_a_wrong_patience_is_refused() -> None:
    with pytest.raises(AgentError, match="porter: patience is a whole number"):
        load_agent("porter:patience=0.5")
