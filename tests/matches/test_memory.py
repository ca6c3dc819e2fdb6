import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import pytest

from bench.memory import sizes


@pytest.mark.slow
def test_matches_that_are_over_leave_nothing_in_memory() -> None:
    """A leak of 1 KB per match, a sixth of one that was found, would add 2.4 MB between the readings.

    In a process of its own: what other tests have left in this one moves its size by more than that.
    """
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as process:
        early, late = process.submit(readings).result()
    assert late - early < 1.5


def readings() -> list[float]:
    return [megabytes for _, megabytes in sizes(matches=5_000, every=2_500)]
