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
        needed = _needed_at(now)
        if not needed or (now.partner_item >= 0 and not _is_walled_in(now, needed)):
            return -1
        smalls = [item for item in np.flatnonzero(now.delivered).tolist() if not now.is_heavy(item)]
        smalls = [item for item in smalls if is_feasible(item) and self._left_until.get(item, 0) <= now.tick]
        fresh = [item for item in smalls if item not in self._left_until]
        if len(fresh) < len(smalls) and not _is_walled_in(now, needed):
            smalls = fresh
        if not smalls:
            return -1
        nearest = min(smalls, key=lambda item: float(np.hypot(*(now.item_pose(item) - now.pose)[:2])))
        self._left_until[nearest] = now.tick + AGAIN_AFTER
        return nearest


def _needed_at(now: Perception) -> list[int]:
    """The items to which there is something to do, among them a heavy one with which the partner waits for help."""
    if now.partner_item < 0:
        return now.waiting
    waits = now.intent is not None and now.is_heavy(now.partner_item)
    return [*now.waiting, now.partner_item] if waits else []


def _is_walled_in(now: Perception, needed: list[int]) -> bool:
    """Whether there is no way to any of these items. An agent without an intent does not ask."""
    if now.intent is None:
        return False
    costs = costs_beside(now.space(), now.pose, [now.item_pose(item) for item in needed])
    return all(cost >= UNREACHED for cost in costs)
