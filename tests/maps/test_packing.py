"""Where the next item goes: the same place as when every candidate is looked at, without taking as long."""

import random
import time
from collections.abc import Iterable
from dataclasses import replace

from movingout.maps import Rect, load_map
from movingout.maps.packing import _first_place, unplaced_items


def one_by_one(places: Iterable[Rect], taken: list[Rect], width: float, height: float) -> Rect | None:
    """The lowest, then leftmost free place, as it says."""
    for place in places:
        for bottom in sorted({place.bottom, *(other.top for other in taken)}):
            for left in sorted({place.left, *(other.right for other in taken)}):
                box = Rect(left, bottom, left + width, bottom + height)
                if _holds(place, box) and not any(_overlap(box, other) for other in taken):
                    return box
    return None


def _holds(place: Rect, box: Rect) -> bool:
    across = box.left >= place.left - 1e-9 and box.right <= place.right + 1e-9
    return across and box.bottom >= place.bottom - 1e-9 and box.top <= place.top + 1e-9


def _overlap(one: Rect, other: Rect) -> bool:
    across = min(one.right, other.right) - max(one.left, other.left)
    return min(across, min(one.top, other.top) - max(one.bottom, other.bottom)) > 2.0**-51


def test_a_place_is_that_of_a_search_one_by_one() -> None:
    numbers, found = random.Random(1), 0

    def rect(most: float) -> Rect:
        x, y = (round(numbers.uniform(-1.2, 1.1), numbers.choice((1, 15))) for _ in range(2))
        return Rect(x, y, x + numbers.choice((0.1, numbers.uniform(0.02, most))), y + numbers.uniform(0.02, most))

    for _ in range(400):
        places, taken = [rect(0.6) for _ in range(numbers.randint(1, 6))], [rect(0.15) for _ in range(12)]
        width = numbers.choice((0.1, numbers.uniform(0.02, 0.4), places[0].right - places[0].left))
        height = numbers.choice((0.1, numbers.uniform(0.02, 0.4)))
        expected = one_by_one(places, taken, width, height)
        assert _first_place(places, taken, width, height) == expected
        found += expected is not None
    assert 50 < found < 350, "some have a place, some have none"


def test_many_goals_beside_many_walls_take_no_seconds() -> None:
    """Every item would fit at many places of each goal, but for the wall in its middle."""
    spec = load_map("HandOff")
    below = [Rect(-0.25 + 0.004 * n, -1.0, -0.249 + 0.004 * n, -0.9) for n in range(29)]
    beside = [Rect(-1.0, -0.25 + 0.004 * n, -0.9, -0.249 + 0.004 * n) for n in range(29)]
    goals = tuple(Rect(-0.2, -0.2, 0.2 + 0.0001 * n, 0.2) for n in range(64))
    items = tuple(replace(item, shape="circle", scale=0.17) for item in spec.items)
    full = replace(spec, walls=(*below, *beside, Rect(-0.04, -0.04, 0.04, 0.04)), goals=goals, items=items)
    started = time.process_time()
    assert unplaced_items(full) == list(range(len(items)))
    assert time.process_time() - started < 2.0
