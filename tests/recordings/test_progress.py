"""Work shared among processes."""

import signal

from movingout.recordings.progress import map_in_processes


def deaf(_: int) -> bool:
    """Whether Ctrl-C would not reach this process."""
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_results_come_in_order_and_ctrl_c_is_left_to_the_parent() -> None:
    assert list(map_in_processes(abs, [-3, 2, -1], 2, "counting")) == [3, 2, 1]
    assert all(map_in_processes(deaf, [0, 1], 2, "asking"))
    assert not deaf(0)


def test_a_single_value_needs_no_process() -> None:
    assert list(map_in_processes(deaf, [0], 8, "asking")) == [False]
