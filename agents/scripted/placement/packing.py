"""Packing: whether all remaining items find a place in the goals."""

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import AXIS, FLOOR, FreeSpace, standing_room
from movingout.agents.scripted.placement.goal_storage import goal_storage, within_goals
from movingout.agents.scripted.placement.remaining_items import RemainingItems, disc_points
from movingout.maps.flood_fill import Mask
from movingout.world.state import Floats

_PUT_DOWN_CLEARANCE = 0.1  # units of clearance around a place where two robots put an item down
_CARRY_CLEARANCES = (
    0.1,
    0.05,
    0.02,
)  # units of clearance on both sides of a heavy item that is carried, preferred first
_SMALL = 0.09  # largest radius of a small item


class Packing:
    """Places the remaining items one after the other, the largest first, each at the deepest free place."""

    def __init__(self, space: FreeSpace, remaining: RemainingItems) -> None:
        sizes = remaining.sizes
        self._heavy = remaining.heavy
        store = goal_storage(space.map)
        rows, columns = np.nonzero(store.inside & (space.clearance > 0.0))
        order = np.lexsort((space.clearance[rows, columns], -store.depth[rows, columns]))
        self._cells = rows[order], columns[order]
        self._x, self._y = AXIS[columns[order]], AXIS[rows[order]]
        self._room = space.clearance[self._cells]
        self._sizes = sizes
        self._gaps: dict[int, Floats] = {}  # by cell: distances to all others
        self._fits = {size: within_goals(space.map, self._x, self._y, size) for size in set(sizes)}
        self._wide = {size: self._ways(space, size) for size in set(sizes) if size > _SMALL}

    def place_all(self, x: float, y: float, radius: float, placeable: Mask) -> tuple[int, int]:
        """(items without a place once a disc lies at (x, y), places that the largest item can choose from)."""
        left = np.minimum(self._room, np.hypot(self._x - x, self._y - y) - radius)
        reached = placeable[self._cells]
        missing, choice = 0, -1
        for size in self._sizes:
            if size <= _SMALL:
                possible = self._fits[size] & reached & (left >= size + 0.01)
            else:
                way = self._carried(x, y, radius, size)
                possible = self._fits[size] & way & (left >= size + _PUT_DOWN_CLEARANCE)
            choice = int(np.count_nonzero(possible)) if choice < 0 else choice
            first = int(possible.argmax()) if possible.size else 0
            if possible.size and possible[first]:
                left = np.minimum(left, self._gaps_to(first) - size)
            else:
                missing += 1
        return missing, max(choice, 0)

    def _gaps_to(self, cell: int) -> Floats:
        """(n,) distances from all cells to one; cached, as the first free cell is often the same."""
        if cell not in self._gaps:
            self._gaps[cell] = np.hypot(self._x[cell] - self._x, self._y[cell] - self._y)
        return self._gaps[cell]

    def _ways(self, space: FreeSpace, size: float) -> tuple[float, list[int], int]:
        """For carrying a heavy item: the clearance that is possible now, the components with it, and the start."""
        start = 0
        for point in self._heavy:
            start |= disc_points(*point, 2 * size + 0.2)  # the item itself is still there
        for abreast in _CARRY_CLEARANCES:
            wide = standing_room(space, size + abreast)
            floor = FLOOR.components(start, wide)
            if any((FLOOR.to_mask(piece)[self._cells] & self._fits[size]).any() for piece in floor):
                return abreast, floor, start
        return 0.0, [], 0

    def _carried(self, x: float, y: float, radius: float, size: float) -> npt.NDArray[np.bool_]:
        """(n,) which cells a heavy item can still be carried to with a disc at (x, y)."""
        abreast, floor, start = self._wide[size]
        if not floor:
            return np.ones(self._x.shape, dtype=np.bool_)
        hole = disc_points(x, y, radius + size + abreast)
        left = sum(FLOOR.connected_around(hole, start, piece) for piece in floor)  # the components are disjoint
        return FLOOR.to_mask(left)[self._cells]
