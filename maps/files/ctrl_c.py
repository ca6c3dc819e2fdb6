"""Whether a KeyboardInterrupt out of somebody else's code is a Ctrl-C, or one that the code raised itself."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

FOREIGN_CODE_RAISES = (Exception, SystemExit, KeyboardInterrupt)
"""What is the fault of an agent, a metric or a family, but for Ctrl-C: ask `is_ctrl_c`."""

_pressed = False


@contextmanager
def noticing_ctrl_c() -> Iterator[None]:
    """In this block, Ctrl-C does what it did before, and `is_ctrl_c` knows of it. Blocks may be nested.

    Where somebody handles SIGINT in a way of their own, they keep it.
    """
    global _pressed
    if not _in_main_thread() or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    _pressed = False
    signal.signal(signal.SIGINT, _note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def is_ctrl_c(error: BaseException) -> bool:
    """Whether an exception that came in a block of `noticing_ctrl_c` ends what runs; also where that is not known."""
    if not isinstance(error, KeyboardInterrupt) or not _in_main_thread():  # signals come to no other thread
        return False
    handler = signal.getsignal(signal.SIGINT)
    return _pressed if handler is _note else handler not in (signal.SIG_IGN, signal.SIG_DFL)


def _note(number: int, frame: FrameType | None) -> None:
    global _pressed
    _pressed = True
    signal.default_int_handler(number, frame)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
