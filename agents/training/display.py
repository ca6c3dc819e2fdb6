"""What is seen of a training while it goes on: a bar on a terminal; in a log, a line a minute."""

import time
from collections.abc import Callable
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

LINE_SECONDS = 60.0


class TrainingDisplay:
    """Used as a context. `clock` gives seconds; the time left is that of the updates made here."""

    def __init__(
        self, updates: int, begun_at: int, console: Console, clock: Callable[[], float] = time.monotonic
    ) -> None:
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        self._bar = Progress(*columns, console=console, disable=not console.is_terminal)
        self._task = self._bar.add_task("training", total=updates, completed=begun_at)
        self._console, self._clock = console, clock
        self._updates, self._begun_at = updates, begun_at
        self._begun = self._last_line = clock()

    def __enter__(self) -> "TrainingDisplay":
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def show(self, update: int, loss: Callable[[], float]) -> None:
        """An update is made; `loss` is only asked for where it is written, since that waits for a GPU."""
        self._bar.update(self._task, completed=update)
        now = self._clock()
        if self._console.is_terminal or (now - self._last_line < LINE_SECONDS and update < self._updates):
            return
        self._last_line = now
        left = (now - self._begun) / (update - self._begun_at) * (self._updates - update)
        ahead = f", about {_duration(left)} left" if update < self._updates else ""
        self._console.print(f"update {update:,} of {self._updates:,}, loss {loss():.4f}{ahead}", markup=False)

    def evaluated(self, loss: float) -> None:
        """The bar says how good the last evaluated update was."""
        self._bar.update(self._task, description=f"loss {loss:.4f}")


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"
