"""When each room ticks: one schedule of absolute deadlines, with rooms staggered within a tick.

A late tick runs late; whole ticks that were missed are skipped and counted, never caught up in a burst. The clock is an
argument, so tests step time by hand; only `run` waits.
"""

import asyncio
import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass

from movingout.server.rooms.lateness import Lateness
from movingout.world.constants import TICK_SECONDS

SLOTS = 50  # of 2 ms
SLOT_STRIDE = 31  # neighbouring slots are filled last
EARLY_S = 0.001  # uvloop's timers may fire up to 1 ms early
MOST_PER_WAKE = 8  # then sockets are served

Tick = Callable[[float, float, int], None]  # now, due, skipped
Beat = Callable[[], None]


@dataclass(eq=False, slots=True)
class ScheduledRoom:
    """One room's place in the schedule."""

    slot: int
    tick: Tick
    beat: Beat
    alive: bool = True


class RoomScheduler:
    """Runs the tick of each entry every `tick_s` (100 ms) and its beat half of that later."""

    def __init__(self, clock: Callable[[], float], tick_s: float = TICK_SECONDS) -> None:
        self.lateness = Lateness()
        self.busy_s = 0.0  # that ticks and beats have taken
        self._tick_s = tick_s
        self._clock = clock
        self._origin = clock()
        self._queue: list[tuple[float, int, ScheduledRoom, bool]] = []
        self._serial = 0
        self._slots = [0] * SLOTS
        self._wake: Callable[[], None] = lambda: None

    def add(self, tick: Tick, beat: Beat) -> ScheduledRoom:
        """Schedule a room, in the slot with the fewest rooms."""
        slot = min(((index * SLOT_STRIDE) % SLOTS for index in range(SLOTS)), key=self._slots.__getitem__)
        self._slots[slot] += 1
        entry = ScheduledRoom(slot, tick, beat)
        self._push(self._grid_time(slot, self._clock()), entry, is_beat=False)
        self._wake()
        return entry

    def remove(self, entry: ScheduledRoom) -> None:
        if entry.alive:
            entry.alive = False
            self._slots[entry.slot] -= 1

    def run_due(self) -> float | None:
        """Run what is due, at most `MOST_PER_WAKE` ticks; returns when to call again, None for never."""
        begun = self._clock()
        for _ in range(MOST_PER_WAKE):
            if not self._queue or self._queue[0][0] > self._clock() + EARLY_S:
                break
            due, _, entry, is_beat = heapq.heappop(self._queue)
            if entry.alive:
                self._run(due, entry, is_beat)
        self.busy_s += self._clock() - begun
        return self._queue[0][0] if self._queue else None

    async def run(self) -> None:
        """Run until cancelled."""
        woken = asyncio.Event()
        self._wake = woken.set
        while True:
            due = self.run_due()
            delay = None if due is None else math.floor((due - self._clock()) * 1e3) / 1e3
            if delay is not None and delay <= 0:
                await asyncio.sleep(0)
                continue
            woken.clear()
            handle = None if delay is None else asyncio.get_running_loop().call_later(delay, woken.set)
            await woken.wait()
            if handle is not None:
                handle.cancel()

    def _run(self, due: float, entry: ScheduledRoom, is_beat: bool) -> None:
        if is_beat:
            entry.beat()
            return
        now = self._clock()
        skipped = max(0, int((now - due) / self._tick_s))
        due += skipped * self._tick_s
        self.lateness.add(max(0.0, now - due) * 1e3, skipped)
        entry.tick(now, due, skipped)
        if entry.alive:
            self._push(self._grid_time(entry.slot, due + self._tick_s / 2), entry, is_beat=False)
            self._push(due + self._tick_s / 2, entry, is_beat=True)

    def _push(self, due: float, entry: ScheduledRoom, is_beat: bool) -> None:
        self._serial += 1
        heapq.heappush(self._queue, (due, self._serial, entry, is_beat))

    def _grid_time(self, slot: int, after: float) -> float:
        """The first time after `after` that belongs to the slot; computed from the origin, so nothing drifts."""
        offset = self._origin + slot * self._tick_s / SLOTS
        return offset + math.ceil((after - offset) / self._tick_s) * self._tick_s
