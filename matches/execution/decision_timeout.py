"""How long an agent may think: a call that takes longer is broken off, wherever its Python code is.

The system's alarm does it (POSIX, main thread). Where there is none, or the agent hangs outside of Python, the worker
process is ended from outside instead (`matches.execution.dispatch`).
"""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_PERIOD_S = 0.5


class TooLate(BaseException):
    """Raised inside an agent's call; no `Exception`, so that an agent that catches everything does not swallow it."""


class Stopwatch:
    """`start()` before each call; while `running()`, a call over the limit raises TooLate. `beat` is called about
    twice a second while calls go on."""

    def __init__(self, limit_s: float, beat: Callable[[], None] = lambda: None) -> None:
        self.limit_s = limit_s
        self._beat = beat
        self._started: float | None = None
        self._last_beat = time.monotonic()

    def start(self) -> None:
        """A call begins."""
        self._started = now = time.monotonic()
        if now - self._last_beat > _PERIOD_S:
            self._last_beat = now
            self._beat()

    def stop(self) -> None:
        """No call is going on."""
        self._started = None

    @contextmanager
    def running(self) -> Iterator[None]:
        """Watch the calls made in this block."""
        if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(signal.SIGALRM, self._look)
        signal.setitimer(signal.ITIMER_REAL, _PERIOD_S, _PERIOD_S)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)

    def _look(self, signum: int, frame: FrameType | None) -> None:
        if self._started is not None and time.monotonic() - self._started > self.limit_s:
            self._started = None
            raise TooLate
