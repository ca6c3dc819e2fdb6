"""The items still to be delivered, and which of them remain reachable when another one is put down."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.navigation.free_space import AXIS, CELLS, FLOOR
from movingout.maps.flood_fill import Mask

Point = tuple[float, float]

_BESIDE = 0.36  # units around an item within which a robot can reach it
_ON_THE_SPOT = 0.15  # units around the partner within which its region begins
_ARM = 8  # cells between the centres of a robot and of the item it puts down


class RemainingItems(NamedTuple):
    """The items still to be delivered apart from one, and the partner that can help."""

    small: tuple[Point, ...]  # positions of items that one robot can carry
    heavy: tuple[Point, ...]  # positions of those that need both
    sizes: tuple[float, ...]  # radii of all remaining items, largest first
    partner: Point | None  # position of the robot that does not hold the item; None when both hold it


class ReachableRegions:
    """The connected regions of free space: those with an item within reach, and the partner's."""

    def __init__(
        self, free: int, remaining: RemainingItems, hole: int = 0, whole: "ReachableRegions | None" = None
    ) -> None:
        """Of the points `free`, less a `hole`; `whole` are the regions without the hole, which speed this up."""
        self._remaining = remaining
        self._hole = hole
        self._known = whole.pieces if whole is not None else []
        self.pieces: list[int] = []  # all components found so far
        self.parts = self._parts(free & ~hole)
        self._partners = 0 if remaining.partner is None else self._around_partner(free & ~hole, remaining.partner)

    def _flood(self, start: int, free: int) -> int:
        """The component that contains the lowest point of `start`."""
        start &= -start
        piece = next((FLOOR.connected_around(self._hole, start, known) for known in self._known if known & start), 0)
        self.pieces.append(piece or FLOOR.connected(start, free))
        return self.pieces[-1]

    def _parts(self, free: int) -> list[int]:
        """The components with an item within reach."""
        parts: list[int] = []
        for x, y in (*self._remaining.small, *self._remaining.heavy):
            beside = disc_points(x, y, _BESIDE) & free
            for part in parts:
                beside &= ~part
            while beside:
                parts.append(self._flood(beside, free))
                beside &= ~parts[-1]
        return parts

    def _around_partner(self, free: int, partner: Point) -> int:
        """The points that are connected with the partner's position."""
        start, reached = disc_points(*partner, _ON_THE_SPOT) & free, 0
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
        """Whether the partner can still reach an item."""
        return self._remaining.partner is None or any(self._partners & part for part in self.parts)

    def placeable(self) -> Mask:
        """Where items can still be put down."""
        whole = self._partners
        for part in self.parts:
            whole |= part
        return FLOOR.to_mask(FLOOR.dilated(whole, _ARM))

    def best_case(self) -> int:
        """The least number of unreachable items over all regions."""
        return min((self.out_of_reach(part) for part in self.parts), default=0)

    def out_of_reach(self, part: int) -> int:
        """How many items neither a robot in this region nor its partner can deliver."""
        theirs = part if self._remaining.partner is None else self._partners
        missed = sum(not disc_points(x, y, _BESIDE) & (part | theirs) for x, y in self._remaining.small)
        for x, y in self._remaining.heavy:
            beside = disc_points(x, y, _BESIDE)
            missed += not (beside & part and beside & theirs)
        return missed


@lru_cache(maxsize=4096)
def disc_points(x: float, y: float, radius: float) -> int:
    """The grid points within a radius of (x, y), as bits."""
    rows, columns = _window(y, radius), _window(x, radius)
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    mask[rows, columns] = np.hypot(AXIS[columns] - x, AXIS[rows, None] - y) < radius
    return FLOOR.to_bits(mask)


def _window(middle: float, radius: float) -> slice:
    first, last = np.searchsorted(AXIS, (middle - radius, middle + radius))
    return slice(int(first), int(last) + 1)
