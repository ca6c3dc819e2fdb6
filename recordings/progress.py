"""Long work shows a bar on a terminal, on standard error; nothing when there is none to see it."""

import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

T = TypeVar("T")
R = TypeVar("R")


def track(values: Iterable[T], total: int, verb: str) -> Iterator[T]:
    """The values, with a bar that names what is being done."""
    console = Console(stderr=True)
    columns = (TextColumn(verb), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal or total < 2) as progress:
        yield from progress.track(values, total=total)


def over_processes(function: Callable[[T], R], values: Sequence[T], workers: int, verb: str) -> Iterator[R]:
    """The results in order, computed by several processes when there are several values."""
    if workers <= 1 or len(values) <= 1:
        yield from track(map(function, values), len(values), verb)
        return
    # spawn: a fork would copy the bar's thread in an unknown state
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        share = max(len(values) // (8 * workers), 1)
        yield from track(pool.map(function, values, chunksize=share), len(values), verb)
