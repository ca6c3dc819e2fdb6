"""Background work of a server that goes on after an error, and tells when it does not succeed any more."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterator

log = logging.getLogger(__name__)

RETRY_S = 1.0
OVERDUE_S = 5.0  # that an interval may be exceeded before it is a fault


class BackgroundWork:
    """Named work that is repeated. Use inside a running event loop."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._tasks: list[asyncio.Task[None]] = []
        self._succeeded: dict[str, tuple[float, float]] = {}  # when, and the interval
        self._failing: set[str] = set()

    def repeat(self, name: str, work: Callable[[], Awaitable[None]], interval_s: float) -> None:
        """Do the work every `interval_s` until `stop`; an error is logged, and the work is done again."""
        self._succeeded[name] = self._clock(), interval_s
        self._tasks.append(asyncio.create_task(self._repeat(name, work, interval_s), name=name))

    def keep_running(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        """Work that does not end by itself: begun again when it fails."""
        self._tasks.append(asyncio.create_task(self._keep_running(name, work), name=name))

    def age_s(self, name: str) -> float:
        """For how long a repeated work has not succeeded; 0 for one that is not repeated here."""
        at, _ = self._succeeded.get(name, (self._clock(), 0.0))
        return self._clock() - at

    def works(self, name: str) -> bool:
        """Whether a repeated work succeeded the last time, and in time; True for one that is not repeated here."""
        _, interval_s = self._succeeded.get(name, (0.0, 0.0))
        return name not in self._failing and self.age_s(name) <= interval_s + OVERDUE_S

    def faults(self) -> Iterator[str]:
        """What has not succeeded for too long, or has ended."""
        for name, (_, interval_s) in self._succeeded.items():
            if self.age_s(name) > interval_s + OVERDUE_S:
                yield f"{name}: not done for {self.age_s(name):.0f} s"
        for task in self._tasks:
            if task.done():
                yield f"{task.get_name()}: ended"

    async def stop(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._tasks.clear()
        self._succeeded.clear()
        self._failing.clear()

    async def _repeat(self, name: str, work: Callable[[], Awaitable[None]], interval_s: float) -> None:
        while True:
            await asyncio.sleep(interval_s)
            try:
                await work()
                self._failing.discard(name)
                self._succeeded[name] = self._clock(), interval_s
            except Exception as error:  # whatever it was, the next time may succeed
                if name not in self._failing:
                    log.exception("%s failed and is tried again: %s", name, error)
                self._failing.add(name)

    async def _keep_running(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        while True:
            try:
                await work()
            except Exception as error:  # the server is worth more than this error
                log.exception("%s failed and is started again: %s", name, error)
            await asyncio.sleep(RETRY_S)
