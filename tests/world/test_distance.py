import math
from dataclasses import replace

import numpy as np
import pytest

from movingout.maps import MapSpec, Rect, load_map
from movingout.world.distance import moves_to, official_distances, paper_distances


@pytest.fixture
def walled() -> MapSpec:
    """A wall from the left side to x = 0.5 at y = 0, the goal in the upper left corner."""
    wall, goal = Rect(-1.2, -0.05, 0.5, 0.05), Rect(-1.2, 1.0, -1.0, 1.2)
    return replace(load_map("Simple"), walls=(wall,), goals=(goal,))


def test_a_flood_counts_moves_in_eight_directions_around_what_is_blocked() -> None:
    blocked = np.zeros((4, 5), dtype=bool)
    blocked[1, :4] = True
    source = np.zeros_like(blocked)
    source[0, 0] = True
    expected = [[0, 1, 2, 3, 4], [1, 1, 2, 3, 4], [8, 7, 6, 5, 5], [8, 7, 6, 6, 6]]
    assert moves_to(source, blocked).tolist() == expected


def test_what_is_walled_off_has_no_way() -> None:
    blocked = np.zeros((3, 3), dtype=bool)
    blocked[1] = True
    source = np.zeros_like(blocked)
    source[0, 0] = True
    assert np.isinf(moves_to(source, blocked)[2]).all()


def test_inside_a_goal_the_distance_is_zero_and_grows_by_a_cell_per_move(walled: MapSpec) -> None:
    distances = paper_distances(walled)
    points = np.array([(-1.1, 1.1), (-0.97, 1.1), (-0.92, 0.97), (-1.1, 0.52)])
    np.testing.assert_allclose(distances.to_goal(points), [0.0, 0.05, 0.1, 0.5])


def test_the_way_leads_around_a_wall(walled: MapSpec) -> None:
    distances = paper_distances(walled)
    below = distances.to_goal(np.array([-1.1, -0.2]))
    assert below > 2 * 1.6  # to the wall's end at x = 0.5 and back
    assert distances.between(np.array([0.0, 0.2]), np.array([0.0, -0.2])) > 2 * 0.5
    assert distances.between(np.array([0.8, 0.22]), np.array([0.8, -0.18])) == pytest.approx(0.4)


def test_distance_between_points_is_symmetric(walled: MapSpec) -> None:
    distances = paper_distances(walled)
    generator = np.random.default_rng(1)
    for _ in range(50):
        a, b = generator.uniform(0.1, 1.1, (2, 2)) * generator.choice((-1, 1), (2, 2))
        assert distances.between(a, b) == distances.between(b, a)


def test_points_beyond_the_arena_belong_to_the_outermost_cells(walled: MapSpec) -> None:
    assert paper_distances(walled).to_goal(np.array([-5.0, 9.0])) == 0.0


def test_lookups_take_any_leading_axes(walled: MapSpec) -> None:
    points = np.random.default_rng(2).uniform(-1.2, 1.2, (4, 3, 2))
    together = paper_distances(walled).to_goal(points)
    assert together.shape == (4, 3)
    assert together[2, 1] == paper_distances(walled).to_goal(points[2, 1])


def test_a_maps_flood_is_made_once() -> None:
    assert paper_distances(load_map("HandOff")) is paper_distances(load_map("HandOff"))


def test_official_distances_are_straight_lines_without_walls() -> None:
    distances = official_distances(load_map("DistancePriority"))  # the goal is [-0.4, 0.4] x [0.6, 1.2]
    assert distances.to_goal(np.array([0.0, 0.0])) == pytest.approx(0.6)
    assert distances.to_goal(np.array([0.7, 0.2])) == pytest.approx(0.5)
    assert distances.to_goal(np.array([0.1, 0.9])) == 0.0
    assert distances.between(distances.place(0.0, 0.0), distances.place(0.3, 0.4)) == pytest.approx(0.5)


def test_official_distances_have_their_own_number_where_there_is_no_way() -> None:
    closed = replace(load_map("Simple"), walls=(Rect(-1.2, -0.05, 1.2, 0.05),), goals=(Rect(-1.2, 1.0, -1.0, 1.2),))
    point = np.array([0.0, -0.5])
    distances = official_distances(closed)
    assert distances.to_goal(point) == 1.44
    assert distances.between(distances.place(0.0, -0.5), distances.place(0.0, 0.5)) == math.inf
    assert math.isinf(paper_distances(closed).to_goal(point))
