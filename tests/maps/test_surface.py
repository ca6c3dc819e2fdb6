"""Distances to an item's surface, against the physics engine's own answer."""

from typing import get_args

import numpy as np
import pymunk
import pytest

from movingout.maps.shapes import corner_radius, outline
from movingout.maps.spec import Shape
from movingout.maps.surface import surface_distance


def solid(shape: Shape, scale: float) -> list[pymunk.Shape]:
    """The item as convex solids of the engine, around the origin."""
    body = pymunk.Body(body_type=pymunk.Body.STATIC)
    if shape == "circle":
        return [pymunk.Circle(body, scale)]
    vertices = list(outline(shape, scale))
    if shape != "star":
        return [pymunk.Poly(body, vertices, radius=corner_radius(shape, scale))]
    notches = vertices[1::2]
    spikes = [[vertices[k - 1], vertices[k], vertices[(k + 1) % 10]] for k in range(0, 10, 2)]
    return [pymunk.Poly(body, corners) for corners in (notches, *spikes)]


@pytest.mark.parametrize("shape", get_args(Shape))
def test_it_is_the_engines_distance_outside_and_negative_inside(shape: Shape) -> None:
    points = np.random.default_rng(3).uniform(-0.4, 0.4, (200, 2))
    found = surface_distance(shape, 0.15, points)
    parts = solid(shape, 0.15)
    for part in parts:
        part.cache_bb()
    expected = np.array([min(part.point_query(tuple(point)).distance for part in parts) for point in points])
    outside = expected > 0
    assert 20 < outside.sum() < 200
    np.testing.assert_allclose(found[outside], expected[outside], atol=1e-9)
    assert (found[~outside] <= 1e-9).all()
