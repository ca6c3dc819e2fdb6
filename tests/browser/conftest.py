"""Fixtures: one server and one Chromium per run, pages that fail the test when they complain."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Playwright, expect, sync_playwright

from tests.browser.chromium import Chromium, close
from tests.browser.install import NoBrowser
from tests.browser.pages import admin_token
from tests.browser.support import DESKTOP, Server, complaints, running_server, seat_tokens_script

OpenPage = Callable[..., Page]
expect.set_options(timeout=20_000.0)  # of 5 s, which a busy machine may need for a page
TRY_S = 420  # the longest takes 66 s on a quiet machine, and a busy one has needed six times as long


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)
            item.add_marker(pytest.mark.timeout(TRY_S))


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with running_server(tmp_path_factory.mktemp("server")) as running:
        yield running


@pytest.fixture(autouse=True)
def _no_room_stays_open(request: pytest.FixtureRequest) -> Iterator[None]:
    """A room that was left waits for its people, and its agent with it: after enough tests no agent would be free."""
    yield
    if "server" in request.fixturenames:
        running: Server = request.getfixturevalue("server")
        running.close_rooms(admin_token(running))


@pytest.fixture(scope="session")
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="session")
def shared_chromium(playwright: Playwright) -> Iterator[Chromium]:
    chromium = Chromium(playwright)
    yield chromium
    chromium.close()


@pytest.fixture
def browser(shared_chromium: Chromium) -> Iterator[Browser]:
    try:
        with shared_chromium.for_a_test() as chromium:
            yield chromium
    except NoBrowser as error:
        pytest.fail(str(error))


@pytest.fixture
def open_page(browser: Browser, server: Server) -> Iterator[OpenPage]:
    """`open_page(path, room=…, script=…, **context options)`: a page in a context of its own.

    `room` (what POST /api/rooms answered) gives it the seats of the lobby. The test fails when a page complains.
    """
    opened: list[tuple[Page, list[str]]] = []

    def make(path: str, room: dict[str, Any] | None = None, script: str = "", **options: Any) -> Page:
        context = browser.new_context(base_url=server.url, **{"viewport": DESKTOP, **options})
        if room is not None:
            context.add_init_script(seat_tokens_script(room))
        if script:
            context.add_init_script(script)
        page = context.new_page()
        opened.append((page, complaints(page)))
        page.goto(path)
        return page

    yield make
    heard = [complaint for _, said in opened for complaint in said]
    close(*(page.context for page, _ in opened))
    assert heard == [], "a page complained"


@pytest.fixture(scope="session")
def pictures() -> Path:
    """Where screenshots go; git ignores the folder."""
    folder = Path(__file__).resolve().parents[2] / "build" / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
