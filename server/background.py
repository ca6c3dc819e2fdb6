"""Background work of a server that goes on after an error, and tells when it does not succeed any more."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import NamedTuple

log = logging.getLogger(__name__)

RETRY_S = 1.0
AGAIN_S = 3.0  # at the latest what has failed is tried again
OVERDUE_S = 5.0  # that an interval may be exceeded, or that something may fail, before it is a fault
STUCK_S = 120.0  # the same for work that may be late: so long takes no slow disk, only one that hangs


class _Failure(NamedTuple):
    since: float
    error: Exception


class BackgroundWork:
    """Named work that is repeated. Use inside a running event loop."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._tasks: list[asyncio.Task[None]] = []
        self._succeeded: dict[str, tuple[float, float]] = {}  # when, and the interval
        self._failing: dict[str, _Failure] = {}
        self._patient: set[str] = set()

    def repeat(
        self, name: str, work: Callable[[], Awaitable[None]], interval_s: float, may_be_late: bool = False
    ) -> None:
        """Do the work every `interval_s` until `stop`; an error is logged, and the work is done again.

        With `may_be_late` it is a fault only that it fails, or takes so long that it seems to hang.
        """
        if may_be_late:
            self._patient.add(name)
        self._succeeded[name] = self._clock(), interval_s
        self._tasks.append(asyncio.create_task(self._repeat(name, work, interval_s), name=name))

    def keep_running(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        """Work that does not end by itself: begun again when it fails."""
        self._tasks.append(asyncio.create_task(self._keep_running(name, work), name=name))

    def age_s(self, name: str) -> float:
        """For how long a repeated work has not succeeded; 0 for one that is not repeated here."""
        at, _ = self._succeeded.get(name, (self._clock(), 0.0))
        return self._clock() - at

    def error(self, name: str) -> Exception | None:
        """What a repeated work failed with the last time, None where it succeeded or is not repeated here."""
        failure = self._failing.get(name)
        return None if failure is None else failure.error

    def stuck(self, name: str) -> bool:
        """Whether a repeated work takes so long that it seems to hang."""
        at, interval_s = self._succeeded.get(name, (self._clock(), 0.0))
        return self._clock() - at - interval_s > STUCK_S

    def faults(self) -> Iterator[str]:
        """What has not succeeded for too long, or has ended."""
        for name, (_, interval_s) in self._succeeded.items():
            failure = self._failing.get(name)
            failing_s = 0.0 if failure is None else self._clock() - failure.since
            late_s = failing_s if name in self._patient else self.age_s(name) - interval_s
            if late_s > OVERDUE_S or self.stuck(name):
                why = "" if failure is None else f" ({reason(failure.error)})"
                yield f"{name}: not done for {self.age_s(name):.0f} s{why}"
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
            await asyncio.sleep(min(interval_s, AGAIN_S) if name in self._failing else interval_s)
            try:
                await work()
                self._failing.pop(name, None)
                self._succeeded[name] = self._clock(), interval_s
            except Exception as error:  # whatever it was, the next time may succeed
                if name not in self._failing:
                    log.exception("%s failed and is tried again: %s", name, error)
                before = self._failing.get(name)
                self._failing[name] = _Failure(self._clock() if before is None else before.since, error)

    async def _keep_running(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        while True:
            try:
                await work()
            except Exception as error:  # the server is worth more than this error
                log.exception("%s failed and is started again: %s", name, error)
            await asyncio.sleep(RETRY_S)


def reason(error: Exception) -> str:
    """Why something failed, without the names of files: strangers read it, too."""
    found = error if isinstance(error, OSError) else error.__cause__
    return (isinstance(found, OSError) and found.strerror) or type(error).__name__
