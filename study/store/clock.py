"""The clock for timestamps: it does not jump while a study runs."""

import time

_STEADY = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)  # goes on while a laptop sleeps, where there is one
_BEGAN_NS = time.time_ns() - time.clock_gettime_ns(_STEADY)


def now_ms() -> int:
    """Milliseconds since the epoch, from the system clock at the start of this process.

    If the system clock is corrected in the middle of a session, durations and pay stay right; where it is set back
    between two runs of a server, `Store.set_back` sees to it.
    """
    return (_BEGAN_NS + time.clock_gettime_ns(_STEADY)) // 1_000_000


def slept_s() -> float:
    """For how long this machine has slept since it was started: what `now_ms` counts and `time.monotonic` does not.

    0 where a system has no clock that goes on in sleep.
    """
    return time.clock_gettime(_STEADY) - time.clock_gettime(time.CLOCK_MONOTONIC)
