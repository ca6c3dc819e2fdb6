"""A process of an agent ends with the one that started it."""

import os
import threading
import time


def end_with_parent() -> None:
    """Watch from now on, in a thread: an agent that hangs does not notice a closed socket or pipe."""
    threading.Thread(target=_watch, args=(os.getppid(),), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(0)
