"""axe finds nothing wrong with the game page in any of its phases, in both themes and languages, on desktop and phone.

The other pages: test_lobby, test_editor, test_replay, test_admin, test_annotate; the screens of a study:
test_study_screens.
"""

from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import OpenPage
from tests.browser.pages import violations
from tests.browser.support import DESKTOP, Server, wait_for

pytestmark = pytest.mark.slow
PHONE: dict[str, Any] = {"viewport": {"width": 375, "height": 553}, "has_touch": True, "is_mobile": True}
LANGUAGES = ["en-GB", "de-DE"]
WINDOWS = [{"viewport": DESKTOP}, PHONE]


@pytest.fixture(params=LANGUAGES)
def language(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=WINDOWS, ids=["desktop", "phone"])
def window(request: pytest.FixtureRequest, language: str) -> dict[str, Any]:
    """Options of a browser context."""
    return {**request.param, "locale": language}


def test_the_tutorial_is_accessible(server: Server, open_page: OpenPage, window: dict[str, Any]) -> None:
    room = server.post("/api/rooms", {"tutorial": True})
    page = open_page(room["join_path"], room, **window)
    wait_for(page, "game.phase === 'playing'")
    assert violations(page) == []
    page.locator("#stop").click()
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay .panel")).to_be_visible()
    assert violations(page) == []


def test_ready_play_pause_settings_and_the_result_are_accessible(
    server: Server, open_page: OpenPage, window: dict[str, Any]
) -> None:
    room = server.make_room("AdaptiveAssist", red="scripted", limit_ticks=150)
    page = open_page(room["join_path"], room, **window)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    ready = page.locator("#ready button.button-primary")
    expect(ready).to_be_visible()
    assert violations(page) == []
    ready.click()
    wait_for(page, "game.phase === 'playing'")
    assert violations(page) == []
    page.locator("#stop").click()
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay .panel")).to_be_visible()
    assert violations(page) == []
    _resume(page)
    wait_for(page, "game.phase.endsWith('_over')", 40)
    expect(page.locator("#result h1, #after h1").first).to_be_visible()
    assert violations(page) == []


def _resume(page: Page) -> None:
    page.locator("#overlay button.button-primary").click()
    wait_for(page, "game.phase === 'playing'")


def test_watching_with_what_agents_consider_is_accessible(
    server: Server, open_page: OpenPage, window: dict[str, Any]
) -> None:
    room = server.make_room("LeftRight", blue="bass@all", red="scripted")
    page = open_page(room["watch_path"], **window)
    page.locator("#decisions button").click(timeout=60_000)
    expect(page.locator(".decision-lists li").first).to_be_visible()
    assert violations(page) == []
