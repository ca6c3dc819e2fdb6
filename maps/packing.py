"""Whether all items of a map fit into its goals at once: boxes into boxes, largest first.

Yes is certain if the items can be turned that way; no can be wrong for a tight fit that players would hardly manage.
"""

import math
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from movingout.maps.shapes import corner_radius, outline
from movingout.maps.spec import ARENA_HALF, GOAL_MARGIN, WALL_MARGIN, ItemSpec, MapSpec, Rect, Shape
from movingout.maps.surface import Floats

_TOLERANCE = 1e-9
_TURNS = np.radians(np.arange(0, 180, 3))


def unplaced_items(spec: MapSpec, spare: float = 0.0) -> list[int]:
    """Indices of the items that do not fit when all are placed in the goals, each with `spare` around it."""
    places = [_usable(goal) for goal in spec.goals]
    taken = [wall.grown(WALL_MARGIN) for wall in spec.walls]
    unplaced = []
    breadths = [smallest_box(item.shape, item.scale) for item in spec.items]
    for index in sorted(range(len(spec.items)), key=lambda i: -breadths[i][0] * breadths[i][1]):
        width, height = (side + 2 * spare for side in breadths[index])
        found = _first_place(places, taken, width, height) or _first_place(places, taken, height, width)
        if found is None:
            unplaced.append(index)
        else:
            taken.append(found)
    return sorted(unplaced)


def fits_alone(item: ItemSpec, spec: MapSpec) -> bool:
    """Whether some goal would hold the item if it were the only one."""
    walls = [wall.grown(WALL_MARGIN) for wall in spec.walls]
    width, height = smallest_box(item.shape, item.scale)
    places = [_usable(goal) for goal in spec.goals]
    return any(_first_place(places, walls, *sides) is not None for sides in ((width, height), (height, width)))


@lru_cache(maxsize=1024)
def smallest_box(shape: Shape, scale: float) -> tuple[float, float]:
    """Width and height of the item's axis-aligned box, turned so that the box is smallest."""
    if shape == "circle":
        return 2 * scale, 2 * scale
    vertices = np.array(outline(shape, scale))
    across = np.stack((np.cos(_TURNS), np.sin(_TURNS)))  # (2, turns)
    up = np.stack((-np.sin(_TURNS), np.cos(_TURNS)))
    margin = 2 * corner_radius(shape, scale)
    widths = np.ptp(vertices @ across, axis=0) + margin
    heights = np.ptp(vertices @ up, axis=0) + margin
    best = int(np.argmin(widths * heights))
    return float(widths[best]), float(heights[best])


def narrowest(shape: Shape, scale: float) -> float:
    """The narrowest breadth of an item over all directions: what must fit through a passage."""
    if shape == "circle":
        return 2 * scale
    across = np.stack((np.cos(_TURNS), np.sin(_TURNS)))
    return float(np.ptp(np.array(outline(shape, scale)) @ across, axis=0).min()) + 2 * corner_radius(shape, scale)


def is_home(box: Rect, goals: Iterable[Rect]) -> bool:
    """Whether an item with this bounding box counts as delivered."""
    margin = GOAL_MARGIN
    return any(
        goal.left - margin <= box.left
        and box.right <= goal.right + margin
        and goal.bottom - margin <= box.bottom
        and box.top <= goal.top + margin
        for goal in goals
    )


def _usable(goal: Rect) -> Rect:
    """Where an item's box may lie to be delivered: the goal with its margin, within the arena."""
    wide = goal.grown(GOAL_MARGIN)
    return Rect(*(max(-ARENA_HALF, min(ARENA_HALF, side)) for side in (wide.left, wide.bottom, wide.right, wide.top)))


def _first_place(places: Iterable[Rect], taken: list[Rect], width: float, height: float) -> Rect | None:
    """The lowest, then leftmost free place for a box, its sides against others' or the region's.

    All candidates of a region at once: of those that a drawn map can have, one by one would take seconds.
    """
    others = np.array([(other.left, other.bottom, other.right, other.top) for other in taken]).reshape(-1, 4)
    for place in places:
        lefts = _starts(place.left, place.right, width, others[:, 2])
        bottoms = _starts(place.bottom, place.top, height, others[:, 3])
        if not len(lefts) or not len(bottoms):
            continue
        across = _overlaps(lefts, width, others[:, [0, 2]])
        up = _overlaps(bottoms, height, others[:, [1, 3]])
        free = (up @ across.T).ravel() == 0.0  # (bottoms * lefts)
        if free.any():
            row, column = divmod(int(np.argmax(free)), len(lefts))
            left, bottom = float(lefts[column]), float(bottoms[row])
            return Rect(left, bottom, left + width, bottom + height)
    return None


def _starts(first: float, last: float, length: float, ends: Floats) -> Floats:
    """Where a side of this length may begin between two bounds: at the first of them, or where something ends."""
    if length > last - first + 3 * _TOLERANCE:
        return np.empty(0)
    starts = np.unique(np.append(ends, first))
    return starts[(starts >= first - _TOLERANCE) & (starts + length <= last + _TOLERANCE)]


def _overlaps(starts: Floats, length: float, others: Floats) -> Floats:
    """1 where a side (S,) overlaps another one (N, 2), else 0: (S, N)."""
    begin = starts[:, None]
    shared = np.minimum(begin + length, others[:, 1]) - np.maximum(begin, others[:, 0])
    return (shared > math.ulp(2.0)).astype(np.float64)
