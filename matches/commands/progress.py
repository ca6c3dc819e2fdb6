"""A progress bar with rate and time left, on standard error; nothing where that is not a terminal."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from movingout.matches.callbacks import OnProgress


@contextmanager
def bar(unit: str) -> Iterator[OnProgress]:
    """Yields the function to call with (finished, all)."""
    console = Console(stderr=True)
    columns = (
        TextColumn(unit), BarColumn(), MofNCompleteColumn(), TaskProgressColumn(show_speed=True),
        TextColumn("{task.fields[rate]}"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task(unit, total=None, rate="")

        def show(finished: int, count: int) -> None:
            speed = progress.tasks[0].speed
            rate = f"{speed:.2f}/s" if speed else ""
            progress.update(task, completed=finished, total=count, rate=rate)

        yield show
