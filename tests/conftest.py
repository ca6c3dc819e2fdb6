"""For all tests: one thread for numerical libraries, since tests run side by side, but one browser at a time.

Tests of servers and browsers play in real time. On a busy machine one of them may miss its moment, so it gets a second
try, and the summary names it; whatever is computed gets none.
"""

import asyncio
import os
from collections.abc import Iterator
from typing import Any

import hypothesis
import pytest
from xdist.scheduler import LoadScopeScheduling

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")  # some tests import onnxruntime before movingout
hypothesis.settings.register_profile("long", max_examples=100_000, deadline=None)


IN_REAL_TIME = ("tests/browser/", "tests/server/", "tests/attacks/")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.nodeid.startswith(IN_REAL_TIME) and item.config.getoption("reruns", None) != 0:  # unless --reruns 0
            item.add_marker(pytest.mark.flaky(reruns=2, reruns_delay=2))


class OneBrowserAtATime(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Files stay together, and so do all that drive a browser: two at once are too slow to play."""

    def _split_scope(self, nodeid: str) -> str:
        path = nodeid.partition("::")[0]
        return "tests/browser" if path.startswith("tests/browser/") else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling:
    return OneBrowserAtATime(config, log)


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
