"""When garbage is collected, so that memory stays level however long people play.

A full collection holds up every room (50 ms with 100 rooms, measured), so it waits for a moment when nobody plays, or
until memory has grown and the last one is a while ago.
"""

import gc
import logging
import time
from collections.abc import Callable

import psutil

log = logging.getLogger(__name__)

THRESHOLDS = (700, 5, 1_000_000)  # the young generations stay small, the old one is collected here
IDLE_S = 60.0  # between two collections while nobody plays
BUSY_S = 120.0  # the same while somebody does
GROWTH_BYTES = 48e6  # since the last collection, before a busy server collects


class GarbageCollection:
    """Collects at good moments. `start` and `stop` change and restore the interpreter's own thresholds."""

    def __init__(self, clock: Callable[[], float] = time.monotonic, rss: Callable[[], int] | None = None) -> None:
        self._clock = clock
        self._rss = rss or (lambda: psutil.Process().memory_info().rss)
        self._before = gc.get_threshold()
        self._at = clock()
        self._rss_then = 0

    def start(self) -> None:
        """Set aside what lives as long as the process."""
        gc.collect()
        gc.freeze()
        gc.set_threshold(*THRESHOLDS)
        self._rss_then = self._rss()

    def stop(self) -> None:
        gc.unfreeze()
        gc.set_threshold(*self._before)

    def consider(self, busy: bool) -> bool:
        """Collect if it is time to; `busy` while anybody plays. Returns whether it did."""
        waited = self._clock() - self._at
        if waited < (BUSY_S if busy else IDLE_S) or (busy and self._rss() - self._rss_then < GROWTH_BYTES):
            return False
        found = gc.collect()
        log.debug("collected %d objects after %.0f s", found, waited)
        self._at, self._rss_then = self._clock(), self._rss()
        return True
