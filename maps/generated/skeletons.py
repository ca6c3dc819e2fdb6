"""The walls of generated maps: templates with drawn numbers, and who and what belongs where among them.

Each template draws in one orientation; a symmetry of the square turns the finished map. Lengths are multiples of 0.05
where nothing else is said, as in maps drawn by hand.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from movingout.maps.spec import ARENA_HALF, Rect

A = ARENA_HALF
ARENA = Rect(-A, -A, A, A)
STEP = 0.05
_T = TypeVar("_T")


class Draw:
    """Round numbers from a random generator."""

    def __init__(self, random: np.random.Generator) -> None:
        self.random = random

    def length(self, least: float, most: float, step: float = STEP) -> float:
        """A multiple of `step`, both ends included."""
        low, high = round(least / step), round(most / step)
        return round(int(self.random.integers(low, high + 1)) * step, 3)

    def whole(self, least: int, most: int) -> int:
        return int(self.random.integers(least, most + 1))

    def chance(self, share: float) -> bool:
        return bool(self.random.random() < share)

    def one_of(self, options: Sequence[_T]) -> _T:
        return options[int(self.random.integers(len(options)))]


@dataclass(frozen=True, slots=True)
class Skeleton:
    """Walls, and the parts of the arena in which goals, items and robots may lie."""

    walls: tuple[Rect, ...] = ()
    goals: tuple[Rect, ...] = ()  # where the template itself says where they are
    goal_area: Rect = ARENA
    item_area: Rect = ARENA
    robot_areas: tuple[Rect, Rect] = (ARENA, ARENA)
    small_only: bool = False  # nothing larger gets through


Template = Callable[[Draw, int], Skeleton]
"""Draws a skeleton for a difficulty from 0 to 2."""


def open_floor(draw: Draw, difficulty: int) -> Skeleton:
    """Nothing, or a few pillars."""
    walls = []
    for _ in range(draw.whole(0, 1 + difficulty)):
        x, y = draw.length(-0.9, 0.7), draw.length(-0.9, 0.7)
        walls.append(_box(x, y, draw.length(0.1, 0.45), draw.length(0.1, 0.45)))
    return Skeleton(tuple(walls))


def corridor(draw: Draw, difficulty: int) -> Skeleton:
    """A room above a dead end that is narrow: items come down it, one robot ahead of the other."""
    width = draw.length(0.4, 0.6) - STEP * difficulty
    left = draw.length(-0.8, 0.8 - width)
    top = draw.length(0.1, 0.6)
    higher = draw.chance(0.4)
    walls = [Rect(-A, top, left, -A), Rect(A, A if higher else top, round(left + width, 3), -A)]
    goal = Rect(left, draw.length(-0.75, -0.45), round(left + width, 3), -A)
    above = Rect(-A, top, round(left + width, 3) if higher else A, A)
    lane = Rect(left, goal.top, round(left + width, 3), top)
    areas = (lane, above) if draw.chance(0.6) else (above, above)
    return Skeleton(tuple(walls), (goal,), item_area=above, robot_areas=areas, small_only=width < 0.45)


def shelves(draw: Draw, difficulty: int) -> Skeleton:
    """Parallel thin walls, each with a way past one of its ends."""
    count = draw.whole(2, 2 + min(difficulty, 1))
    spacing = 2 * A / (count + 1)
    thickness = draw.one_of((0.05, 0.1))
    first = draw.chance(0.5)
    walls = []
    for number in range(count):
        y = _snapped(-A + spacing * (number + 1))
        length = 2 * A - draw.length(0.45, 0.9)
        from_left = (number % 2 == 0) == first if draw.chance(0.8) else draw.chance(0.5)
        walls.append(_box(-A, y, length, thickness) if from_left else _box(A - length, y, length, thickness))
    return Skeleton(tuple(walls))


def blocks(draw: Draw, difficulty: int) -> Skeleton:
    """Boxes in rows and columns with lanes between them."""
    columns, rows = draw.one_of(((2, 2), (2, 2), (3, 2), (1, 2), (2, 1), (3, 1)))
    lane = draw.length(0.35, 0.5) - STEP * min(difficulty, 1)
    margin = draw.length(0.3, 0.45)
    width = _snapped((2 * A - 2 * margin - (columns - 1) * lane) / columns)
    height = _snapped((2 * A - 2 * margin - (rows - 1) * lane) / rows)
    walls = [
        _box(-A + margin + column * (width + lane), -A + margin + row * (height + lane), width, height)
        for column in range(columns)
        for row in range(rows)
    ]
    if len(walls) > 3 and draw.chance(0.3):
        walls.pop(draw.whole(0, len(walls) - 1))
    return Skeleton(tuple(walls))


def ring(draw: Draw, difficulty: int) -> Skeleton:
    """One large block, and a way around it."""
    lane = draw.length(0.4, 0.6) - STEP * difficulty
    width, height = draw.length(0.7, 2 * A - 2 * lane), draw.length(0.7, 2 * A - 2 * lane)
    x, y = draw.length(-A + lane, A - lane - width), draw.length(-A + lane, A - lane - height)
    return Skeleton((_box(x, y, width, height),))


def divider(draw: Draw, difficulty: int) -> Skeleton:
    """A wall across the arena with one or two gaps; items on one side, goals on either."""
    x, thickness = draw.length(-0.35, 0.35), draw.one_of((0.05, 0.1))
    gap = draw.length(0.5, 0.75) - STEP * difficulty
    if draw.chance(0.5):
        begin = draw.length(-0.9, 0.9 - gap)
        walls = [Rect(x, -A, x + thickness, begin), Rect(x, begin + gap, x + thickness, A)]
    else:
        begin = draw.length(-1.05, -0.2 - gap)
        other = draw.length(0.2, 1.05 - gap)
        walls = [Rect(x, -A, x + thickness, begin), Rect(x, begin + gap, x + thickness, other)]
        walls.append(Rect(x, other + gap, x + thickness, A))
    left, right = Rect(-A, -A, x, A), Rect(x + thickness, -A, A, A)
    return Skeleton(tuple(map(_rounded, walls)), item_area=left, goal_area=right if draw.chance(0.75) else ARENA)


def stubs(draw: Draw, difficulty: int) -> Skeleton:
    """Thin walls that jut out from the sides."""
    walls = []
    for side in range(draw.whole(2, 3 + min(difficulty, 1))):
        length, at = draw.length(0.4, 1.1), draw.length(-0.75, 0.7)
        match side % 4:
            case 0:
                walls.append(_box(-A, at, length, STEP))
            case 1:
                walls.append(_box(A - length, at, length, STEP))
            case 2:
                walls.append(_box(at, -A, STEP, min(length, 0.8)))
            case _:
                walls.append(_box(at, A - min(length, 0.8), STEP, min(length, 0.8)))
    return Skeleton(tuple(walls))


def zigzag(draw: Draw, difficulty: int) -> Skeleton:
    """Barriers one behind the other, open now at the sides, now in the middle: things turn on their way."""
    count = 2 + (difficulty > 1)
    ys = [draw.length(0.4, 0.6), draw.length(-0.2, 0.05), -0.6][:count]
    open_middle = draw.chance(0.5)
    walls = []
    for number, y in enumerate(ys):
        if (number % 2 == 0) == open_middle:
            gap, middle = draw.length(0.55, 0.9) - STEP * difficulty, draw.length(-0.3, 0.3)
            walls += [Rect(-A, y, middle - gap / 2, y + STEP), Rect(middle + gap / 2, y, A, y + STEP)]
        else:
            half = draw.length(0.5, 0.7)
            walls.append(Rect(-half, y, half, y + STEP))
    item_area = Rect(-A, 0.1, A, A)
    return Skeleton(tuple(map(_rounded, walls)), item_area=item_area, goal_area=Rect(-A, -A, A, -0.1))


def rooms(draw: Draw, difficulty: int) -> Skeleton:
    """Three or four rooms with doors between them."""
    x, y = draw.length(-0.25, 0.25), draw.length(-0.25, 0.25)
    door = draw.length(0.45, 0.6) - STEP * (difficulty > 1)
    walls: list[Rect] = []
    for low, high in ((-A, y), (y + STEP, A))[: draw.whole(1, 2)]:
        begin = _door(draw, low, high, door)
        walls += [Rect(x, low, x + STEP, begin), Rect(x, begin + door, x + STEP, high)]
    for low, high in ((-A, x), (x + STEP, A)):
        begin = _door(draw, low, high, door)
        walls += [Rect(low, y, begin, y + STEP), Rect(begin + door, y, high, y + STEP)]
    return Skeleton(tuple(map(_rounded, walls)))


def _door(draw: Draw, low: float, high: float, width: float) -> float:
    """Where a door in a wall from `low` to `high` begins: at least 0.15 from its ends."""
    return draw.length(low + 0.15, high - width - 0.15)


TEMPLATES: Mapping[str, tuple[Template, ...]] = {
    "coordination": (corridor, shelves, blocks, ring, divider, rooms),
    "awareness": (open_floor, stubs, divider, ring, blocks, shelves),
    "action consistency": (open_floor, divider, zigzag, stubs, ring, shelves),
}
"""The templates of each mode, all equally likely."""


def _box(x: float, y: float, width: float, height: float) -> Rect:
    return _rounded(Rect(x, y, x + width, y + height))


def _rounded(rect: Rect) -> Rect:
    """To thousandths, so that the numbers are the same on every machine, and within the arena."""
    sides = (rect.left, rect.bottom, rect.right, rect.top)
    return Rect(*(round(min(max(side, -A), A), 3) + 0.0 for side in sides))


def _snapped(length: float) -> float:
    return round(round(length / STEP) * STEP, 3)
