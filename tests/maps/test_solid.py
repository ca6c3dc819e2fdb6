import math
from dataclasses import replace

import numpy as np
import pytest

from movingout.maps import ItemSpec, Pose, Rect
from movingout.maps.shapes import circumradius
from movingout.maps.solid import beyond_arena, item_solid, robot_solid, wall_solid
from movingout.maps.spec import SHAPES


def item(shape: str, x: float = 0.0, y: float = 0.0, angle: float = 0.0, scale: float = 0.1) -> ItemSpec:
    return ItemSpec(0, shape, "small", scale, 0.1, Pose(x, y, angle))  # type: ignore[arg-type]


def test_the_gap_of_two_robots_is_what_is_between_their_sides() -> None:
    assert robot_solid(Pose(0, 0, 0)).gap(robot_solid(Pose(0.2, 0.2, 1))) == pytest.approx(0.2 * math.sqrt(2) - 0.24)
    assert robot_solid(Pose(0, 0, 0)).gap(robot_solid(Pose(0.1, 0, 0))) < 0


def test_walls_are_a_hundredth_thicker_than_drawn() -> None:
    wall = wall_solid(Rect(0.5, 1.0, -0.5, 0.9))
    assert robot_solid(Pose(0.0, 0.7, 0.0)).gap(wall) == pytest.approx(0.2 - 0.12 - 0.01)
    assert robot_solid(Pose(0.0, 0.95, 0.0)).gap(wall) < 0  # inside, far from all sides


def test_two_squares_corner_to_corner_and_side_to_side() -> None:
    side = math.sqrt(math.pi) * 0.1
    assert item_solid(item("square")).gap(item_solid(item("square", x=2 * side))) == pytest.approx(0.98 * side)
    turned = item_solid(item("square", x=2 * side, angle=math.pi / 4))
    assert item_solid(item("square")).gap(turned) == pytest.approx((2 - 0.5 - math.sqrt(0.5) - 0.02) * side)


def test_crossed_planks_overlap_though_no_corner_is_inside_the_other() -> None:
    assert item_solid(item("rectangle")).gap(item_solid(item("rectangle", angle=math.pi / 2))) < 0


def test_a_small_thing_inside_a_large_one_overlaps_it() -> None:
    assert item_solid(item("octagon", scale=0.3)).gap(item_solid(item("star", scale=0.02))) < 0
    assert item_solid(item("circle", scale=0.02)).gap(item_solid(item("octagon", scale=0.3))) < 0


def test_something_fits_between_the_tips_of_a_star() -> None:
    star = item_solid(item("star", scale=0.3))
    notch = math.pi / 5
    ball = item("circle", x=-0.3 * math.sin(notch), y=0.3 * math.cos(notch), scale=0.03)
    assert star.gap(item_solid(ball)) > 0
    assert star.gap(item_solid(replace(ball, scale=0.1))) < 0


@pytest.mark.parametrize("shape", SHAPES)
def test_gaps_do_not_depend_on_order_or_on_where_the_pair_stands(shape: str) -> None:
    generator = np.random.default_rng(5)
    for other in SHAPES:
        x, y, turn = generator.uniform(-0.25, 0.25, 3)
        one, two = item(shape, angle=turn), item(other, x=x, y=y, angle=2 * turn)
        moved = [replace(i, pose=Pose(i.pose.x + 0.2, i.pose.y - 0.1, i.pose.angle)) for i in (one, two)]
        gap = item_solid(one).gap(item_solid(two))
        assert item_solid(two).gap(item_solid(one)) == pytest.approx(gap)
        assert item_solid(moved[0]).gap(item_solid(moved[1])) == pytest.approx(gap)
        breadths = circumradius(shape, 0.1) + circumradius(other, 0.1)  # type: ignore[arg-type]
        assert gap >= math.hypot(x, y) - 1.02 * breadths or gap == -math.inf


def test_sticking_out_of_the_arena_is_measured() -> None:
    assert beyond_arena(robot_solid(Pose(1.1, 0, 0))) == pytest.approx(0.02)
    assert beyond_arena(robot_solid(Pose(0, -1.0, 0))) == pytest.approx(-0.08)
