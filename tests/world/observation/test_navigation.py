"""Ways around walls."""

import numpy as np

from movingout.maps import load_map
from movingout.world.observation.navigation import FAR, navigation, on_grid


def test_following_the_direction_leads_around_the_wall_to_the_goal_on_maps_with_walls() -> None:
    for name in ("HandOff", "PassOrSplit", "EfficientRoutes", "SequentialRotations"):
        the_map = load_map(name)
        ways = navigation(the_map)
        places = np.array([[item.pose.x, item.pose.y] for item in the_map.items])
        goals = ways.nearest_goal(on_grid(places))
        for _ in range(200):
            places = places + 0.05 * ways.ways(on_grid(places), goals)[0]
        assert (np.linalg.norm(places - goals.points, axis=1) < 0.15).all(), name


def test_a_way_without_walls_is_the_straight_line() -> None:
    ways = navigation(load_map("DistancePriority"))
    here, there = np.array([-0.9, -0.4]), np.array([0.5, 0.8])
    direction, length = ways.ways(on_grid(here), on_grid(there))
    assert length == np.linalg.norm(there - here)
    assert np.allclose(direction, (there - here) / np.linalg.norm(there - here))


def test_a_way_around_a_wall_is_longer_than_the_birds_and_no_way_is_reported_where_there_is_one() -> None:
    the_map = load_map("PassOrSplit")
    ways = navigation(the_map)
    item = np.array([the_map.items[0].pose.x, the_map.items[0].pose.y])
    length = float(ways.ways(on_grid(item), ways.nearest_goal(on_grid(item)))[1])
    assert 5.0 < length < FAR
