"""Worker processes for slow work; they end with the process that started them."""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from types import TracebackType

BREAK_OFF_S = 2.0  # how long work that has begun may still take after an exception


class StoppablePool(ProcessPoolExecutor):
    """Used in a `with`: when that ends by an exception, by Ctrl-C too, work that has not begun is dropped.

    What has begun is broken off soon after. Ctrl-C does nothing meanwhile: a pool that is left half ended would make
    the program hang at its own end.
    """

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.shutdown()
            return
        with _sigint_ignored():
            self.end(BREAK_OFF_S)

    def end(self, within_s: float) -> None:
        """Drop work that has not begun, wait so long for what has, and break it off then."""
        manager: threading.Thread | None = getattr(self, "_executor_manager_thread", None)
        processes = [*(self._processes or {}).values()]
        self.shutdown(wait=False, cancel_futures=True)
        if manager is None:
            return
        manager.join(within_s)
        if manager.is_alive():
            for process in processes:
                process.kill()
            manager.join()


@contextlib.contextmanager
def _sigint_ignored() -> Iterator[None]:
    """Signals come to the main thread alone, and only there may this be said."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def process_pool(workers: int, nice: int = 0) -> StoppablePool:
    """A pool of processes with this `nice` value that leave Ctrl-C to their parent and do not outlive it.

    They are spawned: a fork would copy threads in an unknown state. What they print goes to standard error: standard
    output is for the answer of their parent.
    """
    context = multiprocessing.get_context("spawn")
    return StoppablePool(workers, mp_context=context, initializer=_begin, initargs=(nice,))


def _begin(nice: int) -> None:
    os.nice(nice)
    sys.stdout = sys.stderr
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """After kill -9 of the parent nothing else would end a worker: it would wait for work for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
