"""Interdependence: the share of deliveries that the partner's carrying enabled, from recorded states alone.

A constructive dependency after Biswas et al., "Who is Helping Whom? Analyzing Inter-dependencies to Evaluate
Cooperation in Human-AI Teaming" (arXiv 2502.06976): one agent's action brings about what the other's relies on. There
it is read off symbolic preconditions; here off who carried an item nearer to its goal.

Each spell of a hand on an item counts for its seat: the distance to the goal at its start minus that at its end. An
item that is delivered now was delivered by the hand that held it last. The partner enabled the delivery when the sum
of its own spells is positive: it carried the item a part of the way, alone earlier or together with the deliverer.
Where both held it to the last, both sums must be positive. Items that nobody ever held are left out.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from movingout.world.state import Floats, WorldState

NOTHING = 1e-9  # lengths and distances below it count as none (official value)
NOBODY = (-1, -1)


class Interdependence:
    """Follows the hands of one episode: a comparison per tick, two look-ups whenever a hand opens or closes.

    `distance` gives the way [u] from a point (2,) to the nearest goal.
    """

    def __init__(self, items: int, distance: Callable[[Floats], float]) -> None:
        self._distance = distance
        self._held = NOBODY
        self._began = [0.0, 0.0]  # per seat: the distance at which its spell began
        self._nearer = [[0.0] * items, [0.0] * items]  # per seat and item: by how much its ended spells brought it
        self._last: list[tuple[int, ...]] = [()] * items  # seats that held it last

    def see(self, state: WorldState) -> None:
        """Take in a state; call it with every state of an episode, in order."""
        blue, red = state.held.tolist()
        if (blue, red) == self._held:
            return
        for seat, (before, now) in enumerate(zip(self._held, (blue, red), strict=True)):
            if before != now:
                self._end_spell(seat, before, state)
                if now >= 0:
                    self._began[seat] = self._distance(state.item_poses[now, :2])
        for item in {blue, red} - {-1}:
            self._last[item] = tuple(seat for seat, held in enumerate((blue, red)) if held == item)
        self._held = blue, red

    def share(self, delivered: npt.NDArray[np.bool_], item_poses: Floats) -> float | None:
        """Of the items delivered now and ever held, the share that a partner enabled; None when there are none.

        `delivered` is (N,), `item_poses` (N, 3), both of the last state that was seen.
        """
        items = [int(item) for item in np.flatnonzero(delivered) if self._last[item]]
        if not items:
            return None
        return sum(self._enabled(item, item_poses) for item in items) / len(items)

    def _enabled(self, item: int, item_poses: Floats) -> bool:
        partners = {1 - seat for seat in self._last[item]}
        return all(self._brought(seat, item, item_poses) > NOTHING for seat in partners)

    def _brought(self, seat: int, item: int, item_poses: Floats) -> float:
        """By how much a seat has brought an item nearer, with the spell that still goes on."""
        ended = self._nearer[seat][item]
        if self._held[seat] != item:
            return ended
        return ended + self._began[seat] - self._distance(item_poses[item, :2])

    def _end_spell(self, seat: int, item: int, state: WorldState) -> None:
        if item >= 0:
            self._nearer[seat][item] += self._began[seat] - self._distance(state.item_poses[item, :2])
