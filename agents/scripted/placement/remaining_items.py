"""What is still to be delivered, and which part of it can be reached when something stands on the floor."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.navigation.free_space import AXIS, CELLS, FLOOR
from movingout.maps.flood_fill import Mask

Point = tuple[float, float]

_BESIDE = 0.36  # units around an item from which it counts as within reach
_ON_THE_SPOT = 0.15  # units around the partner's place from which it starts
_ARM = 8  # cells between a robot's centre and that of an item it puts down


class RemainingItems(NamedTuple):
    """What is still to be delivered besides an item, and who else can do it."""

    small: tuple[Point, ...]  # where items wait that one robot can carry
    heavy: tuple[Point, ...]  # and those that need both
    sizes: tuple[float, ...]  # radii of all the items to come, the largest first
    partner: Point | None  # the robot that does not hold the item in question; None when both hold it


class ReachableRegions:
    """How the floor is divided: its parts with an item beside them, and what the partner reaches of it."""

    def __init__(
        self, free: int, remaining: RemainingItems, hole: int = 0, whole: "ReachableRegions | None" = None
    ) -> None:
        """Of the floor `free`; of what a hole leaves of it, where `whole` is the division of the floor without one."""
        self._remaining = remaining
        self._hole = hole
        self._known = whole.pieces if whole is not None else []
        self.pieces: list[int] = []  # all that hangs together as far as it was looked at
        self.parts = self._parts(free & ~hole)
        self._partners = 0 if remaining.partner is None else self._around_partner(free & ~hole, remaining.partner)

    def _flood(self, start: int, free: int) -> int:
        """The piece of the floor that hangs together with the lowest point of `start`."""
        start &= -start
        piece = next((FLOOR.connected_around(self._hole, start, known) for known in self._known if known & start), 0)
        self.pieces.append(piece or FLOOR.connected(start, free))
        return self.pieces[-1]

    def _parts(self, free: int) -> list[int]:
        """The separate parts of the floor that have an item beside them."""
        parts: list[int] = []
        for x, y in (*self._remaining.small, *self._remaining.heavy):
            beside = around(x, y, _BESIDE) & free
            for part in parts:
                beside &= ~part
            while beside:
                parts.append(self._flood(beside, free))
                beside &= ~parts[-1]
        return parts

    def _around_partner(self, free: int, partner: Point) -> int:
        """The floor that hangs together with the partner's place."""
        start, reached = around(*partner, _ON_THE_SPOT) & free, 0
        for part in self.parts:
            if start & part:
                reached |= part
                start &= ~part
        while start:
            piece = self._flood(start, free)
            reached |= piece
            start &= ~piece
        return reached

    @property
    def partner_can_work(self) -> bool:
        """Whether the other robot can still go to an item."""
        return self._remaining.partner is None or any(self._partners & part for part in self.parts)

    def placeable(self) -> Mask:
        """Where items can be put down by robots that still get about."""
        whole = self._partners
        for part in self.parts:
            whole |= part
        return FLOOR.to_mask(FLOOR.dilated(whole, _ARM))

    def best_case(self) -> int:
        """How many items are out of reach at least, whatever is done."""
        return min((self.out_of_reach(part) for part in self.parts), default=0)

    def out_of_reach(self, part: int) -> int:
        """How many items cannot be reached by a robot in this part of the floor and its partner."""
        theirs = part if self._remaining.partner is None else self._partners
        missed = sum(not around(x, y, _BESIDE) & (part | theirs) for x, y in self._remaining.small)
        for x, y in self._remaining.heavy:
            beside = around(x, y, _BESIDE)
            missed += not (beside & part and beside & theirs)
        return missed


@lru_cache(maxsize=4096)
def around(x: float, y: float, radius: float) -> int:
    """The grid points nearer to (x, y) than a radius."""
    rows, columns = _window(y, radius), _window(x, radius)
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    mask[rows, columns] = np.hypot(AXIS[columns] - x, AXIS[rows, None] - y) < radius
    return FLOOR.to_bits(mask)


def _window(middle: float, radius: float) -> slice:
    first, last = np.searchsorted(AXIS, (middle - radius, middle + radius))
    return slice(int(first), int(last) + 1)
