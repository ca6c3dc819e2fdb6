"""The time limit of an agent's decision: a call that takes longer is interrupted wherever its Python code is.

A POSIX alarm in the main thread does it. Where there is none, or where the agent hangs outside Python, the worker
process is killed instead (`matches.execution.local_workers`).
"""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_PERIOD_S = 0.5
_STILL_S = 5.0  # without an alarm, and hardly any computing: the process was stopped, as by Ctrl-Z or a cluster


class DecisionTimeout(BaseException):
    """Raised inside an agent's call, with its limit in seconds.

    Not an `Exception`, so that agents that catch every exception do not catch it.
    """


class DecisionTimer:
    """Interrupts calls that exceed the limit: `start()` before each call and `stop()` after it, inside `running()`."""

    def __init__(self, limit_s: float, heartbeat: Callable[[], None] = lambda: None) -> None:
        """`heartbeat` is called about twice a second as long as calls are made."""
        self.limit_s = limit_s
        self._heartbeat = heartbeat
        self._started: float | None = None
        self._allowed_s = limit_s
        self._last_heartbeat = time.monotonic()
        self._checked = self._last_heartbeat, time.process_time()

    def start(self, at_least_s: float = 0.0) -> None:
        """A call begins, which may take the limit, or `at_least_s` if that is longer."""
        self._started = now = time.monotonic()
        self._allowed_s = max(self.limit_s, at_least_s)
        if now - self._last_heartbeat > _PERIOD_S:
            self._last_heartbeat = now
            self._heartbeat()

    def stop(self) -> None:
        """The call has ended."""
        self._started = None

    @contextmanager
    def running(self) -> Iterator[None]:
        """Enforce the limit in this block. Raises DecisionTimeout in a call that exceeds it."""
        if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
            yield
            return
        self._checked = time.monotonic(), time.process_time()
        before = signal.signal(signal.SIGALRM, self._check)
        signal.setitimer(signal.ITIMER_REAL, _PERIOD_S, _PERIOD_S)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)

    def _check(self, signum: int, frame: FrameType | None) -> None:
        stopped_s = self._stopped_s()
        if self._started is None:
            return
        self._started += stopped_s
        if time.monotonic() - self._started > self._allowed_s:
            self._started = None
            raise DecisionTimeout(self._allowed_s)
        if self._allowed_s > self.limit_s:  # otherwise the silence between two calls is short enough
            self._heartbeat()

    def _stopped_s(self) -> float:
        """For how long the process stood still since the last alarm, which is not the agent's fault."""
        (at, computed), self._checked = self._checked, (time.monotonic(), time.process_time())
        passed, computing = self._checked[0] - at, self._checked[1] - computed
        return passed if passed > _STILL_S and computing < passed / 10 else 0.0
