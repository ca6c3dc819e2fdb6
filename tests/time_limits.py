"""Nothing in a run of tests waits without end: no try of a test, no end of its fixtures, no end of a worker.

pytest-timeout sets its timer once for all tries of a test and takes it away at the first failure, lest it disturb a
debugger; and a timer that has gone off limits nothing any more. Here each try and each end of fixtures has a timer of
its own. No timer interrupts a call in C, and asyncio swallows one that goes off in a callback. So a little later a
watchdog writes the stacks of all threads and ends the worker; xdist then names the test and ends the run.
"""

import faulthandler
import os
import sys
from collections.abc import Generator
from typing import Any

import pytest
import pytest_timeout

FIXTURES_END_S = 180.0  # 16 s have been measured on a busy machine
WATCHDOG_AFTER_S = 120.0  # the timer
WORKER_ENDS_S = 300.0
ENDED_BY_TIMER = "from pytest-timeout"  # what its failures say: there is no time for another try

_stderr = pytest.StashKey[int]()  # of a worker; during a test, file 2 is another
_worker_died = pytest.StashKey[bool]()


def pytest_configure(config: pytest.Config) -> None:
    if hasattr(config, "workerinput"):
        assert sys.__stderr__ is not None
        config.stash[_stderr] = os.dup(sys.__stderr__.fileno())


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    _limit(item, float("inf"))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    _limit(item, FIXTURES_END_S)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()  # a worker may have to wait long for its next test


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    if error is not None:
        node.config.stash[_worker_died] = True


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    _watch(session.config, WORKER_ENDS_S)
    if session.config.stash.get(_worker_died, False) and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED  # xdist alone takes that for success


@pytest.hookimpl(trylast=True)
def pytest_unconfigure() -> None:
    faulthandler.cancel_dump_traceback_later()  # a worker stays until the last one has ended


def _limit(item: pytest.Item, most_s: float) -> None:
    """From now on the test has the time that it is given, at most `most_s`."""
    settings = pytest_timeout._get_item_settings(item)
    if settings.timeout:
        settings = settings._replace(timeout=min(settings.timeout, most_s))
        item.ihook.pytest_timeout_cancel_timer(item=item)
        item.ihook.pytest_timeout_set_timer(item=item, settings=settings)
        _watch(item.config, settings.timeout + WATCHDOG_AFTER_S)


def _watch(config: pytest.Config, most_s: float) -> None:
    if _stderr in config.stash:
        faulthandler.dump_traceback_later(most_s, exit=True, file=config.stash[_stderr])
