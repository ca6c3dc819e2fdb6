"""Worker processes for slow work; they end with the process that started them."""

import multiprocessing
import os
import signal
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from types import TracebackType


class StoppablePool(ProcessPoolExecutor):
    """Used in a `with`: when that ends by an exception, by Ctrl-C too, work that has not begun is dropped."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.shutdown(cancel_futures=kind is not None)

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
