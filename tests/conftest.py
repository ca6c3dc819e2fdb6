"""For all tests: one thread for numerical libraries, since tests run side by side, but one browser at a time."""

import asyncio
import os
from collections.abc import Iterator

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")


def pytest_itemcollected(item: pytest.Item) -> None:
    """Files stay together (`--dist loadgroup`), and all that drive a browser: two at once are too slow to play."""
    folder = item.path.parent.name
    item.add_marker(pytest.mark.xdist_group("browser" if folder == "browser" else item.nodeid.partition("::")[0]))


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
