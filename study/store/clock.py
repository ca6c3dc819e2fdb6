"""The time that is written down: one that does not jump while a study runs."""

import time

_STEADY = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)  # goes on while a laptop sleeps, where there is one
_BEGAN_NS = time.time_ns() - time.clock_gettime_ns(_STEADY)


def now_ms() -> int:
    """Milliseconds since the epoch, by the clock as it stood when this process began.

    If the machine's clock is put right in the middle of a session, durations and pay are still what they were.
    """
    return (_BEGAN_NS + time.clock_gettime_ns(_STEADY)) // 1_000_000
