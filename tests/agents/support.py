"""Agents that behave well or badly on purpose; workers load them as `tests.agents.support:Name`."""

import os
import signal
import threading
import time

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError

HERE = "tests.agents.support"


class Forward:
    """Drives ahead; `rows` rows per chunk of which `execute` are meant to be played."""

    def __init__(self, rows: int = 1, execute: int = 1, distance: float = 1.0) -> None:
        self.rows = rows
        self.execute_rows = execute
        self.distance = distance
        self.detail = {"rows": rows}

    def reset(self, episode: EpisodeInfo) -> None:
        self.episode = episode

    def act(self, observation: Observation) -> ActionChunk:
        return np.tile([self.distance, 1.0, 0.0, 0.0], (self.rows, 1))


class Raising(Forward):
    """Raises in each tick from `first` up to `last`."""

    error: Exception = ValueError("I do not know this place")

    def __init__(self, first: int = 0, last: int = 10**9) -> None:
        super().__init__()
        self.first, self.last = first, last

    def act(self, observation: Observation) -> ActionChunk:
        if self.first <= observation.tick <= self.last and observation.state.tick > 0:
            raise self.error
        return super().act(observation)


class NotUtf8(Raising):
    """Raises with the name of a file that is not UTF-8, as Python reads it."""

    error = OSError("no such file: caf\udce9.txt")


class NotUtf8AgentError(Raising):
    """Likewise, with an error of this project."""

    error = AgentError("no such file: caf\udce9.txt")


class Untrained(Forward):
    """Can be made, and answers nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        raise ValueError("no weights")


class Flat(Forward):
    """Answers one row instead of a chunk of rows."""

    def act(self, observation: Observation) -> ActionChunk:
        row: ActionChunk = super().act(observation)[0]
        return row


class NotANumber(Forward):
    def act(self, observation: Observation) -> ActionChunk:
        chunk = super().act(observation)
        if observation.state.tick > 0:
            chunk[0, 0] = np.nan
        return chunk


class Hanging(Forward):
    """Never answers for tick `at`."""

    def __init__(self, at: int = 3) -> None:
        super().__init__()
        self.at = at

    def act(self, observation: Observation) -> ActionChunk:
        while observation.tick == self.at:
            time.sleep(0.1)
        return super().act(observation)


class Dying(Forward):
    """Takes its process with it at every tick from 1 on."""

    def act(self, observation: Observation) -> ActionChunk:
        if observation.state.tick > 0:
            os._exit(3)
        return super().act(observation)


class Hungry(Forward):
    """Asks for 80 GB from tick 1 on."""

    def act(self, observation: Observation) -> ActionChunk:
        return np.ones(10**10) if observation.state.tick > 0 else super().act(observation)


class Threaded(Forward):
    """From tick 1 on, computes for ever in threads of its own; `short`: in new ones, which end with the decision."""

    def __init__(self, threads: int = 1, short: bool = False) -> None:
        super().__init__()
        self.threads, self.short = threads, short

    def act(self, observation: Observation) -> ActionChunk:
        if observation.state.tick == 1 or (self.short and observation.state.tick > 0):
            begun = [threading.Thread(target=self._compute, daemon=True) for _ in range(self.threads)]
            for thread in begun:
                thread.start()
            for thread in begun if self.short else ():
                thread.join()
        return super().act(observation)

    def _compute(self) -> None:
        begun = time.thread_time()
        while not self.short or time.thread_time() < begun + 0.05:
            sum(range(1000))


def broken_factory() -> Forward:
    raise RuntimeError("no weights here")


def ending_factory() -> Forward:
    """Ends the program instead of making an agent."""
    raise SystemExit(2)


def interrupting_factory() -> Forward:
    """Raises what Ctrl-C raises."""
    raise KeyboardInterrupt("mine")


def pressing_factory() -> Forward:
    """Somebody presses Ctrl-C while it makes an agent."""
    signal.raise_signal(signal.SIGINT)
    return Forward()


def not_an_agent() -> object:
    return object()
