"""Processes for slow work do what they are given, and end with the one that they work for, however that ends."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures.process import BrokenProcessPool

import pytest

from movingout.recordings import process_pool as pools
from movingout.recordings.process_pool import process_pool

KILLED_AT_WORK = """
import os, signal
from movingout.recordings.process_pool import process_pool

if __name__ == "__main__":
    print(process_pool(1).submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_work_is_done_in_another_process_that_gives_way() -> None:
    with process_pool(1, nice=3) as processes:
        assert processes.submit(os.getpid).result() != os.getpid()
        assert processes.submit(os.nice, 0).result() == min(os.nice(0) + 3, 19)


def test_when_the_work_is_broken_off_what_has_not_begun_is_dropped() -> None:
    with pytest.raises(KeyboardInterrupt), process_pool(1) as processes:
        futures = [processes.submit(time.sleep, 0.05) for _ in range(100)]
        futures[0].result()
        raise KeyboardInterrupt
    assert sum(future.cancelled() for future in futures) > 50


def test_a_second_ctrl_c_does_not_keep_what_has_begun_from_being_broken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pools, "BREAK_OFF_S", 0.3)
    before = signal.getsignal(signal.SIGINT)  # which shells ignore in what they start in the background
    again = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt, match="the first"), process_pool(1) as processes:
        begun = processes.submit(time.sleep, 20)
        while not begun.running():
            time.sleep(0.01)
        again.start()
        raise KeyboardInterrupt("the first")
    again.join()
    assert time.monotonic() - began < 10 and isinstance(begun.exception(), BrokenProcessPool)
    assert signal.getsignal(signal.SIGINT) is before


def test_after_kill_9_no_worker_is_left_behind() -> None:
    command = [sys.executable, "-c", KILLED_AT_WORK]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as killed:
        assert killed.stdout is not None
        worker = int(killed.stdout.readline())
        said, _ = killed.communicate(timeout=60)  # up to the end of the pipe, which a living worker would keep open
        assert (said, killed.returncode) == ("", -signal.SIGKILL) and worker != killed.pid


def test_what_does_not_end_in_time_is_broken_off() -> None:
    processes = process_pool(1)
    assert processes.submit(abs, -1).result() == 1
    endless = processes.submit(time.sleep, 60)
    while not endless.running():
        time.sleep(0.01)
    began = time.monotonic()
    processes.end(0.2)
    assert time.monotonic() - began < 10
    with pytest.raises(BrokenProcessPool):
        endless.result()
