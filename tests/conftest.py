"""For all tests: one thread for numerical libraries, since tests run side by side, but one browser at a time.

Tests of servers and browsers play in real time. On a busy machine one of them may miss its moment, so it gets a second
try, and the summary names it; whatever is computed gets none. Nor does a test that hung (tests/time_limits.py), but for
those of a browser: Chromium stops answering now and then, and the next try gets a new one.
"""

import asyncio
import logging
import os
import signal
from collections import Counter
from collections.abc import Iterator
from typing import Any

import hypothesis
import pytest
from xdist.scheduler import LoadScopeScheduling

from tests import time_limits

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")  # some tests import onnxruntime before movingout
os.environ.setdefault("PIP_COMPILE", "no")  # what tests install is hardly used: half the time of an installation
hypothesis.settings.register_profile("long", max_examples=100_000, deadline=None)


IN_REAL_TIME = ("tests/browser/", "tests/server/", "tests/attacks/")
LONG = (
    "tests/browser/",
    "tests/agents/environment/test_stacks.py",
    "tests/attacks/test_soak.py",
    "tests/matches/paper/",
    "tests/agents/kinds/test_paper_networks.py",
    "tests/server/cluster/",
    "tests/packaging/",
)


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(time_limits)
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as a shell starts what runs in the background
        signal.signal(signal.SIGINT, signal.default_int_handler)  # some tests press Ctrl-C


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if hasattr(config, "workerinput"):  # side by side: what takes long first, lest a worker waits for the other's last
        sizes = Counter(_scope(item.nodeid) for item in items)
        items.sort(key=lambda item: (not item.nodeid.startswith(LONG), -sizes[_scope(item.nodeid)]))
    for item in items:
        if item.nodeid.startswith(IN_REAL_TIME) and item.config.getoption("reruns", None) != 0:  # unless --reruns 0
            for_good = [] if item.nodeid.startswith("tests/browser/") else [time_limits.ENDED_BY_TIMER]
            item.add_marker(pytest.mark.flaky(reruns=2, reruns_delay=2, rerun_except=for_good))


def _scope(nodeid: str) -> str:
    path = nodeid.partition("::")[0]
    return "tests/browser" if path.startswith("tests/browser/") else path


class OneBrowserAtATime(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Files stay together, and so do all that drive a browser: two at once are too slow to play."""

    def __init__(self, config: pytest.Config, log: Any) -> None:
        super().__init__(config, log)
        config.option.loadscopereorder = False  # in the order of `pytest_collection_modifyitems`

    def _split_scope(self, nodeid: str) -> str:
        return _scope(nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling:
    return OneBrowserAtATime(config, log)


@pytest.fixture(autouse=True)
def _no_log_of_another_test() -> Iterator[None]:
    """Commands send the log to a stream of their test, which is closed after it; servers of a session write on."""
    before = logging.getLogger().handlers[:]
    yield
    for handler in logging.getLogger().handlers[:]:
        if handler not in before:
            logging.getLogger().removeHandler(handler)


@pytest.fixture(autouse=True)
def _no_loop_of_a_browser(request: pytest.FixtureRequest) -> Iterator[None]:
    """Playwright's loop stays marked as running in this thread between its tests; others may want one of their own."""
    if request.node.get_closest_marker("browser"):
        yield
        return
    left = asyncio._get_running_loop()
    asyncio._set_running_loop(None)
    yield
    asyncio._set_running_loop(left)
