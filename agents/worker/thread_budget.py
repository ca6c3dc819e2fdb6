"""What agents compute in threads of their own, beside the one thread that decides, and which of them computes too much.

Decisions are measured and limited by the server. Nobody waits for what other threads do, so that nobody would notice.
"""

import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

MOST_CORES = 0.4  # a thread that never waits gets half of a core, even beside decisions without end
WINDOW_S = 5.0  # that the limit is an average over
LOOK_S = 0.5
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}  # for what a process starts
_TASKS = Path("/proc/self/task")  # of Linux; elsewhere only threads that end within a decision find their agent


class Spent(NamedTuple):
    """Seconds of the processor: of the whole process, and of the thread that decides."""

    process: float
    thread: float

    @property
    def elsewhere(self) -> float:
        return self.process - self.thread


def spent_now() -> Spent:
    return Spent(time.process_time(), time.thread_time())


def thread_seconds(thread: int) -> float:
    """What a thread of this process has used so far, 0 for one that has ended."""
    try:
        return int((_TASKS / str(thread) / "schedstat").read_bytes().split()[0]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def thread_numbers() -> frozenset[int]:
    try:
        return frozenset(map(int, os.listdir(_TASKS)))
    except OSError:
        return frozenset()


class Overrun(NamedTuple):
    """An agent that computes too much, and how many cores all threads but the deciding one took."""

    agent: object
    cores: float


class ThreadBudget:
    """Used by the thread that decides: `deciding` and `loading` around what agents do, `overrun` now and then.

    Threads belong to the agent that was at work when they were first seen.
    """

    def __init__(
        self,
        most_cores: float = MOST_CORES,
        clock: Callable[[], float] = time.monotonic,
        spent: Callable[[], Spent] = spent_now,
        threads: Callable[[], frozenset[int]] = thread_numbers,
        seconds: Callable[[int], float] = thread_seconds,
    ) -> None:
        self.most = most_cores
        self._clock, self._spent, self._threads, self._seconds = clock, spent, threads, seconds
        self._known = threads()
        self._owners: dict[int, object] = {}  # by thread
        self._seen: dict[int, float] = {}  # seconds of a thread, when it was looked at last
        self._looked = clock()
        self._begin()

    def _begin(self) -> None:
        self._since = self._clock()
        self._elsewhere = self._spent().elsewhere
        self._by_agent: defaultdict[int, float] = defaultdict(float)  # seconds
        self._agents: dict[int, object] = {}  # kept, so that nobody else gets their number

    @contextmanager
    def loading(self) -> Iterator[None]:
        """Around the loading of an agent, whose libraries may use threads once."""
        before = self._spent().elsewhere
        try:
            yield
        finally:
            self._elsewhere += self._spent().elsewhere - before

    @contextmanager
    def deciding(self, *agents: object) -> Iterator[None]:
        """Around a decision of these agents."""
        before = self._spent().elsewhere
        try:
            yield
        finally:
            self.claim(agents[0])
            each = (self._spent().elsewhere - before) / len(agents)
            for agent in agents:
                self._note(agent, each)

    def claim(self, agent: object) -> None:
        """Threads that are new belong to this agent."""
        now = self._threads()
        if now == self._known:
            return
        for thread in now - self._known:
            self._owners[thread], self._seen[thread] = agent, 0.0
        for thread in self._owners.keys() - now:
            del self._owners[thread], self._seen[thread]
        self._known = now

    def overrun(self) -> Overrun | None:
        """Who has spent more than the limit allows in the last seconds, when somebody has."""
        now = self._clock()
        if now - self._looked < LOOK_S:
            return None
        self._looked = now
        for thread, agent in self._owners.items():
            before, self._seen[thread] = self._seen[thread], self._seconds(thread)
            self._note(agent, self._seen[thread] - before)
        elapsed, used = now - self._since, self._spent().elsewhere - self._elsewhere
        if used > self.most * max(elapsed, WINDOW_S):
            worst = max(self._by_agent, key=self._by_agent.__getitem__, default=None)
            return Overrun(None if worst is None else self._agents[worst], used / elapsed)
        if elapsed >= WINDOW_S:
            self._begin()
        return None

    def _note(self, agent: object, seconds: float) -> None:
        if seconds > 0.0:
            self._by_agent[id(agent)] += seconds
            self._agents[id(agent)] = agent
