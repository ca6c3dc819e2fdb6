"""A progress bar for long work, on standard error, where that is a terminal."""

import contextlib
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from movingout.recordings.process_pool import process_pool

T = TypeVar("T")
R = TypeVar("R")
_LONGEST_SHARE = 4  # values handed to a process at once


def with_progress(values: Iterable[T], total: int, verb: str) -> Iterator[T]:
    """The values, with a progress bar labelled with `verb`."""
    console = Console(stderr=True)
    columns = (TextColumn(verb), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal or total < 2) as progress:
        yield from progress.track(values, total=total)


def map_in_processes(function: Callable[[T], R], values: Sequence[T], workers: int, verb: str) -> Iterator[R]:
    """The results in order, computed by several processes when there are several values.

    Ctrl-C stops it, and soon after also what is being worked on.
    """
    if workers <= 1 or len(values) <= 1:
        yield from with_progress(map(function, values), len(values), verb)
        return
    with process_pool(workers) as processes:
        share = max(min(len(values) // (8 * workers), _LONGEST_SHARE), 1)
        with _sigint_blocked():
            results = processes.map(function, values, chunksize=share)
        yield from with_progress(results, len(values), verb)


@contextlib.contextmanager
def _sigint_blocked() -> Iterator[None]:
    """Blocks SIGINT while processes start, so that Ctrl-C reaches only this one from their first instruction on."""
    before = signal.pthread_sigmask(
        signal.SIG_BLOCK, {signal.SIGINT}
    )  # children inherit the mask; here the signal is only delayed
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
