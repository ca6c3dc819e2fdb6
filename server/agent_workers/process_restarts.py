"""A process that is replaced whenever it ends: it is a fault when it is away for long, or ends again and again."""

import time
from collections import deque
from collections.abc import Callable, Iterator

AWAY_S = 30.0  # without it: longer than a start takes
MANY, WITHIN_S = 5, 60.0  # ends in so short a time: the next one will end, too


class ProcessRestarts:
    """Told when the process was last there, and of each end. `what` it is called."""

    def __init__(self, what: str, clock: Callable[[], float] = time.monotonic) -> None:
        self.restarts = 0
        self._what = what
        self._clock = clock
        self._seen = clock()
        self._ends: deque[float] = deque(maxlen=MANY)

    def seen(self) -> None:
        """It is there now, or was until now."""
        self._seen = self._clock()

    def ended(self, by_itself: bool = True) -> None:
        """Another one is started; not `by_itself` when a task that it was given is to blame."""
        self.restarts += 1
        if by_itself:
            self._ends.append(self._clock())

    def faults(self) -> Iterator[str]:
        now = self._clock()
        if now - self._seen > AWAY_S:
            yield f"{self._what}: away for {now - self._seen:.0f} s"
        if len(self._ends) == MANY and now - self._ends[0] < WITHIN_S:
            yield f"{self._what}: ended {MANY} times within a minute"
