"""Runs of tests that hang, in small: each ends in seconds, fails and names the test."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CONFTEST = """
import time, pytest
from tests import time_limits

time_limits.FIXTURES_END_S = 0.5
time_limits.WATCHDOG_AFTER_S = 0.5
time_limits.WORKER_ENDS_S = 1.0

def pytest_configure(config):
    config.pluginmanager.register(time_limits)

@pytest.fixture
def hangs_at_its_end():
    yield
    time.sleep(60)
"""
# PyDLL keeps the lock of the interpreter: no Python code, and so no timer, runs until the call has ended.
IN_C = """
import ctypes, signal

def test_it():
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
    ctypes.PyDLL(None).sleep(60)
"""
SECOND_TRY = """
import time, pytest
from tests import time_limits

tries = []

@pytest.mark.flaky(reruns=2, rerun_except=time_limits.ENDED_BY_TIMER)
def test_it():
    tries.append(1)
    assert len(tries) > 1
    time.sleep(60)
"""
END_AFTER_FAILURE = "def test_it(hangs_at_its_end):\n    assert False\n"
END_OF_WORKER = "def test_it():\n    pass\n"


def run(folder: Path, test: str, *options: str, conftest: str = CONFTEST) -> str:
    """What a run of one test file prints that fails within half a minute."""
    (folder / "pytest.ini").write_text("[pytest]\ntimeout = 0.5\n", encoding="ascii")
    (folder / "conftest.py").write_text(conftest, encoding="ascii")
    (folder / "test_hanging.py").write_text(test, encoding="ascii")
    command = [sys.executable, "-m", "pytest", "-rfER", "-p", "no:cacheprovider", f"--rootdir={folder}", *options]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_a_second_try_has_a_limit_and_what_hangs_is_not_tried_again(tmp_path: Path) -> None:
    said = run(tmp_path, SECOND_TRY)
    assert "FAILED test_hanging.py::test_it - Failed: Timeout (>0.5s)" in said
    assert "1 failed, 1 rerun" in said


def test_the_end_of_a_fixture_has_a_limit_after_a_failure(tmp_path: Path) -> None:
    said = run(tmp_path, END_AFTER_FAILURE)
    assert "ERROR test_hanging.py::test_it - Failed: Timeout (>0.5s)" in said


@pytest.mark.slow
def test_what_no_timer_reaches_ends_with_its_worker_and_is_named(tmp_path: Path) -> None:
    said = run(tmp_path, IN_C, "-n", "2", "--max-worker-restart", "0")
    assert "FAILED test_hanging.py::test_it" in said
    assert 'test_hanging.py", line 6 in test_it' in said, "the stacks"
    assert said.count("node down") == 1


@pytest.mark.slow
def test_a_worker_that_does_not_end_is_ended(tmp_path: Path) -> None:
    hanging = "def pytest_sessionfinish(session):\n    time.sleep(60 * hasattr(session.config, 'workerinput'))\n"
    said = run(tmp_path, END_OF_WORKER, "-n", "1", "--max-worker-restart", "0", conftest=CONFTEST + hanging)
    assert "in pytest_sessionfinish" in said, "the stacks"
