"""Whether running games leave room for more: how much of a core their ticks take, and how many of them begin late.

What else the process does, such as answering web pages, is no reason to refuse a game as long as ticks are in time.
"""

from collections.abc import Callable
from typing import NamedTuple

from movingout.server.rooms.scheduler import RoomScheduler
from movingout.server.settings import Limits

SAMPLES = 5.0  # that a share is averaged over
LATE_MS = 50.0  # half a tick: whoever plays notices
FEWEST_TICKS = 10  # in a sample, for a share of late ones to mean something


class ProcessHealth(NamedTuple):
    """What one process with rooms says of itself."""

    cpu_share: float = 0.0  # of one core, for people to see
    busy: bool = False  # games leave no room for more
    agents: bool = False  # can be asked
    faults: tuple[str, ...] = ()  # what does not work and will not by itself, in English
    unwritable: str = ""  # why a round that began now would not be recorded, as far as was tried, in English


class Overload:
    """Sampled once a second from the scheduler."""

    def __init__(self, scheduler: RoomScheduler, limits: Limits, clock: Callable[[], float]) -> None:
        self._scheduler = scheduler
        self._limits = limits
        self._clock = clock
        self.tick_share = 0.0  # of one core
        self.late_share = 0.0  # of the ticks; one that was skipped counts as late
        self._before = self._figures()

    def sample(self) -> None:
        before, self._before = self._before, self._figures()
        seconds, busy, ticks, late = (now - then for now, then in zip(self._before, before, strict=True))
        if seconds > 0.0 and ticks >= 0:  # fewer than before: the measurement began anew
            self.tick_share += (busy / seconds - self.tick_share) / SAMPLES
            recent = late / ticks if ticks >= FEWEST_TICKS else 0.0
            self.late_share += (recent - self.late_share) / SAMPLES

    @property
    def busy(self) -> bool:
        """Whether no room should be opened."""
        return self.tick_share > self._limits.tick_share or self.late_share > self._limits.late_share

    def _figures(self) -> tuple[float, float, int, int]:
        lateness = self._scheduler.lateness
        late = lateness.later_than(LATE_MS) + lateness.skipped
        return self._clock(), self._scheduler.busy_s, lateness.ticks, late
