"""Delivered small items that are in the way: which of them one seat moves to a better place next."""

from collections.abc import Callable

import numpy as np

from movingout.agents.scripted.navigation.walking_route import costs_beside
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED

AGAIN_AFTER = 60  # ticks after which who is walled in moves an item again


class Rearrangement:
    """What one seat has moved so in one episode."""

    def __init__(self) -> None:
        self._left_until: dict[int, int] = {}  # by item that was to be moved: the tick

    def next_item(self, now: Perception, is_feasible: Callable[[int], bool]) -> int:
        """The nearest delivered small item, -1 for none; each once, unless the robot is walled in."""
        if not now.waiting or now.partner_item >= 0:
            return -1
        smalls = [item for item in np.flatnonzero(now.delivered).tolist() if not now.is_heavy(item)]
        smalls = [item for item in smalls if is_feasible(item) and self._left_until.get(item, 0) <= now.tick]
        fresh = [item for item in smalls if item not in self._left_until]
        if len(fresh) < len(smalls) and not _is_walled_in(now):
            smalls = fresh
        if not smalls:
            return -1
        nearest = min(smalls, key=lambda item: float(np.hypot(*(now.item_pose(item) - now.pose)[:2])))
        self._left_until[nearest] = now.tick + AGAIN_AFTER
        return nearest


def _is_walled_in(now: Perception) -> bool:
    """Whether there is no way to any item that waits. An agent without an intent does not ask."""
    if now.intent is None:
        return False
    costs = costs_beside(now.space(), now.pose, [now.item_pose(item) for item in now.waiting])
    return all(cost >= UNREACHED for cost in costs)
