"""Outlines of items: their areas by calculation, their vertices by the official environment's."""

import json
import math

import pytest

from movingout.maps.shapes import circumradius, corner_radius, outline
from movingout.maps.spec import SHAPES, Shape
from tests.support import reference

SCALE = 0.11


def area(shape: Shape) -> float:
    points = outline(shape, SCALE)
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True)) / 2


@pytest.mark.parametrize("shape", ["square", "pentagon", "hexagon", "octagon"])
def test_shapes_have_the_area_of_a_circle_of_their_scale(shape: Shape) -> None:
    assert area(shape) == pytest.approx(math.pi * SCALE**2)


def test_a_triangle_is_a_fifth_shorter_and_a_rectangle_half_as_high() -> None:
    assert area("triangle") == pytest.approx(0.8**2 * math.pi * SCALE**2)
    assert area("rectangle") == pytest.approx(math.pi * SCALE**2 / 2)


@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape not in ("circle", "square", "rectangle")])
def test_the_first_vertex_points_up_and_the_rest_go_counter_clockwise(shape: Shape) -> None:
    x, y = outline(shape, SCALE)[0]
    assert x == 0
    assert y == pytest.approx(circumradius(shape, SCALE))
    assert area(shape) > 0


def test_a_circle_has_no_vertices_and_its_scale_as_radius() -> None:
    assert outline("circle", SCALE) == ()
    assert circumradius("circle", SCALE) == SCALE


def test_outlines_equal_the_official_ones() -> None:
    for name, official in json.loads(reference("item_shapes.json").read_text()).items():
        shape, _, scale_text = name.split("|")
        scale = float(scale_text)
        vertices = [tuple(vertex) for part in official["shapes"] for vertex in part.get("verts", ())]
        assert set(outline(shape, scale)) <= set(vertices), name
        assert official["shapes"][0]["radius"] == (corner_radius(shape, scale) if vertices else scale), name
