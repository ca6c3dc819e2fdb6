"""People at real browsers play: keys, gamepads, touch, reloads and spectators."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.browser.pilot import Pilot, Plan, play
from tests.browser.support import PHONE, Server, wait_for

OpenPage = Callable[..., Page]


BLUE_ON_SIMPLE: Plan = [("grab", 0), ("deliver", 0, -0.9, 0.9), ("grab", 2), ("deliver", 2, -0.8, 0.9)]
RED_ON_SIMPLE: Plan = [("grab", 1), ("deliver", 1, 0.9, 0.9)]


def start(*pages: Page) -> None:
    """Everybody presses the grab key when ready; the 3-2-1 runs."""
    for page in pages:
        wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    for page in pages:
        page.wait_for_function("() => document.querySelector('#ready button')?.textContent === 'I am ready'")
        page.get_by_role("button", name="I am ready").first.click()
    for page in pages:
        wait_for(page, "game.phase === 'playing'")


def test_two_browsers_play_a_whole_game_by_key_presses(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("Simple")
    blue = open_page(room["join_path"], room)
    red = open_page(room["join_path"])
    start(blue, red)
    play(Pilot(blue, 0, BLUE_ON_SIMPLE), Pilot(red, 1, RED_ON_SIMPLE), timeout_s=55)
    assert blue.evaluate("window.__movingout.result.outcome") == "delivered"
    assert "Everything is delivered" in blue.locator("#result").inner_text()
