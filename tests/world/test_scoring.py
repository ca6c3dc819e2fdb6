"""Which items are delivered, for one moment and for many."""

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.world.scoring import delivered_items, delivered_many


@pytest.mark.parametrize("name", ["FourCorners", "HandOff", "AdaptiveAssist"])
def test_many_moments_are_judged_as_each_alone(name: str) -> None:
    the_map = load_map(name)
    random = np.random.default_rng(5)
    count, moments = len(the_map.items), 400
    poses = random.uniform(-1.2, 1.2, (moments, count, 3))
    for moment in range(0, moments, 2):  # half of them in a goal or across its edge
        for item in range(count):
            goal = the_map.goals[random.integers(len(the_map.goals))]
            poses[moment, item, :2] = random.uniform((goal.left, goal.bottom), (goal.right, goal.top))
    many = delivered_many(the_map, poses)
    assert np.array_equal(many, [delivered_items(the_map, each) for each in poses])
    assert 0 < many.sum() < many.size / 2
