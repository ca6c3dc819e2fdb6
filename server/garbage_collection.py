"""When garbage is collected, so that memory stays level however long people play.

A full collection holds up every room (50 ms with 100 rooms, measured), so it waits for a moment when nobody plays, or
until much may have become garbage and the last one is a while ago. What counts is objects, not the memory of the
process: that stays where garbage once took it, and each collection would wait for more of it than the one before.
"""

import gc
import logging
import time
from collections.abc import Callable

log = logging.getLogger(__name__)

THRESHOLDS = (700, 5, 1_000_000)  # the young generations stay small, the old one is collected here
IDLE_S = 60.0  # between two collections while nobody plays
BUSY_S = 60.0  # the same while somebody does
GROWTH_OBJECTS = 20_000  # since the last collection, before a busy server collects: the garbage of 60 rounds


def objects_since_collection() -> int:
    """How many more containers there are than after the last full collection, to a few thousand."""
    young, middle, _ = THRESHOLDS
    return gc.get_count()[2] * young * (middle + 1)


class GarbageCollection:
    """Collects at good moments. `start` and `stop` change and restore the interpreter's own thresholds."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, growth: Callable[[], int] = objects_since_collection
    ) -> None:
        self._clock = clock
        self._growth = growth
        self._before = gc.get_threshold()
        self._at = clock()

    def start(self) -> None:
        """Set aside what lives as long as the process."""
        gc.collect()
        gc.freeze()
        gc.set_threshold(*THRESHOLDS)

    def stop(self) -> None:
        gc.unfreeze()
        gc.set_threshold(*self._before)

    def consider(self, busy: bool) -> bool:
        """Collect if it is time to; `busy` while anybody plays. Returns whether it did."""
        waited = self._clock() - self._at
        if waited < (BUSY_S if busy else IDLE_S) or (busy and self._growth() < GROWTH_OBJECTS):
            return False
        found = gc.collect()
        log.debug("collected %d objects after %.0f s", found, waited)
        self._at = self._clock()
        return True
