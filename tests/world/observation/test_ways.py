"""Ways by arrays are those of the plain formula, to the bit, also on maps with many walls, and take little memory."""

import itertools
import tracemalloc

import numpy as np
import pytest

from movingout.maps import Rect
from movingout.world.observation.ways import CLEARANCE, WayFinder
from movingout.world.state import Floats

GOALS = (Rect(-1.2, -1.2, -0.8, -0.8), Rect(0.7, 0.8, 1.2, 1.1))


def drawn_walls(count: int, seed: int) -> tuple[Rect, ...]:
    """Walls of any size, some over others."""
    random = np.random.default_rng(seed)
    corners, sides = random.uniform(-1.2, 1.1, (count, 2)), random.uniform(0.01, 0.3, (count, 2))
    return tuple(
        Rect(float(x), float(y), float(x + w), float(y + h)) for (x, y), (w, h) in zip(corners, sides, strict=True)
    )


def dots(across: int) -> tuple[Rect, ...]:
    """Small walls in rows, so far apart that nearly all of their corners can be turned at."""
    places = np.linspace(-0.96, 0.96, across)
    return tuple(Rect(float(x), float(y), float(x + 0.001), float(y + 0.001)) for x in places for y in places)


def drawn_points(shape: tuple[int, ...], seed: int) -> Floats:
    return np.random.default_rng(seed).uniform(-1.15, 1.15, (*shape, 2))


def met(wall: Rect, start: tuple[float, float], target: tuple[float, float]) -> bool:
    """The formula for one line and one wall."""

    def clear(x: float, y: float) -> float:
        apart = max(wall.left - x, x - wall.right, wall.bottom - y, y - wall.top)
        return min(CLEARANCE, apart - 1e-6) if apart > 0.0 else -1.0

    margin = min(clear(*start), clear(*target))
    enter, leave = 0.0, 1.0
    for low, high, here, there in zip((wall.left, wall.bottom), (wall.right, wall.top), start, target, strict=True):
        step = there - here if abs(there - here) >= 1e-9 else 1e-9
        first, second = (low - margin - here) / step, (high + margin - here) / step
        enter, leave = max(enter, min(first, second)), min(leave, max(first, second))
    return enter < leave and margin > -0.5


@pytest.mark.parametrize(("count", "seed"), [(0, 0), (1, 1), (5, 2), (12, 3), (24, 4), (64, 5), (64, 6)])
def test_lines_are_blocked_as_by_the_plain_formula(count: int, seed: int) -> None:
    walls = drawn_walls(count, seed)
    finder, starts, targets = WayFinder(walls, GOALS), drawn_points((4, 6), seed), drawn_points((9,), seed + 100)
    starts[:, :2], starts[:, 2, 0] = targets[:2], targets[3, 0]  # the same place; straight up
    starts[0, 3] = -0.0, 0.0
    plain = [
        any(met(wall, (start[0], start[1]), (target[0], target[1])) for wall in walls)
        for start, target in itertools.product(starts.reshape(-1, 2).tolist(), targets.tolist())
    ]
    found = finder.blocked(starts[:, :, None], targets)
    assert found.shape == (4, 6, 9) and found.reshape(-1).tolist() == plain


@pytest.mark.parametrize("walls", [drawn_walls(3, 1), drawn_walls(9, 2), drawn_walls(30, 3), dots(5)])
def test_ways_from_corners_are_the_shortest_of_all_corners(walls: tuple[Rect, ...]) -> None:
    finder = WayFinder(walls, GOALS)
    target = finder.seen(drawn_points((6, 5), 7))
    plain = (finder._along + target.corners[..., None, :]).min(axis=-1)
    assert np.array_equal(finder._beyond(target), plain)
    hidden = (target.corners == np.inf).all(axis=-1).any()
    assert hidden or len(walls) < 30


def test_many_walls_take_little_memory() -> None:
    """What is computed at once stays small: time follows it, and whoever decides has a tenth of a second."""
    finder = WayFinder(dots(8), GOALS)
    assert len(finder.corners) > 150
    points = drawn_points((8, 5), 1)
    tracemalloc.start()
    seen = finder.seen(points)
    finder.between(seen, seen)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 6e6
