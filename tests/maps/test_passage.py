from dataclasses import replace

import numpy as np
import pytest

from movingout.maps import Rect, load_map
from movingout.maps.packing import fits_alone, narrowest, smallest_box, unplaced_items
from movingout.maps.passage import areas_near, best_near, clearance, robot_areas, way_to_goal

GOAL = (Rect(-1.2, 0.8, -0.8, 1.2),)


def door(width: float) -> tuple[Rect, ...]:
    """A wall across the arena at y = 0 with a door between x = 0 and x = width, as drawn."""
    return (Rect(-1.2, -0.05, 0.0, 0.05), Rect(width, -0.05, 1.2, 0.05))


def test_a_way_is_as_wide_as_its_narrowest_door() -> None:
    ways = way_to_goal(door(0.5), GOAL)
    assert best_near(ways, 0.5, 0.7) > 0.3
    assert best_near(ways, 0.25, -0.7) == pytest.approx(0.24, abs=0.013)  # half the door, less the wall's 0.01


def test_behind_a_closed_wall_no_robot_has_a_way() -> None:
    walls = (Rect(-1.2, -0.05, 1.2, 0.05),)
    assert best_near(way_to_goal(walls, GOAL), 0.0, -0.7) < 0
    assert areas_near(walls, 0.0, -0.7).isdisjoint(areas_near(walls, 0.0, 0.7))


@pytest.mark.parametrize(("width", "joined"), [(0.2, False), (0.35, True)])
def test_a_robot_needs_a_door_of_its_own_breadth(width: float, joined: bool) -> None:
    areas = areas_near(door(width), -0.5, 0.7), areas_near(door(width), 0.5, -0.7)
    assert areas[0].isdisjoint(areas[1]) is not joined


def test_an_open_arena_is_one_area() -> None:
    assert set(np.unique(robot_areas(()))) == {0, 1}
    assert clearance(()).max() == pytest.approx(1.2)


def test_breadths_of_shapes() -> None:
    side = np.sqrt(np.pi)
    assert smallest_box("square", 1.0) == pytest.approx((1.02 * side, 1.02 * side))
    assert sorted(smallest_box("rectangle", 1.0)) == pytest.approx([side / 2 + 0.02 * side, 1.02 * side])
    assert narrowest("rectangle", 1.0) == pytest.approx(side / 2 + 0.02 * side)
    assert narrowest("circle", 1.0) == 2.0


def test_items_are_placed_until_the_goals_are_full() -> None:
    spec = load_map("FourCorners")
    assert unplaced_items(spec) == []
    one_goal = replace(spec, goals=spec.goals[:1])
    assert len(unplaced_items(one_goal)) == 3
    assert all(fits_alone(item, one_goal) for item in spec.items)
    assert not any(fits_alone(item, replace(spec, goals=(Rect(0.0, 0.0, 0.1, 0.1),))) for item in spec.items)
