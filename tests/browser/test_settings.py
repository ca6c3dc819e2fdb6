"""The dialog for keys and buttons at the game page."""

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.browser.support import Server

OpenPage = Callable[..., Page]


def hold_enter(page: Page) -> None:
    """A little long, so that it repeats."""
    for _ in range(3):
        page.keyboard.down("Enter")
    page.keyboard.up("Enter")


@pytest.mark.slow
def test_a_key_that_is_held_long_is_one_press(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    page.get_by_role("button", name="Change…").click()
    page.get_by_role("button", name="grab: Space").focus()
    hold_enter(page)
    expect(page.get_by_role("button", name="press a key")).to_be_focused()
    hold_enter(page)
    expect(page.get_by_role("alert")).to_contain_text("Enter is already used for: grab (Second keys). Swap the two?")
    expect(page.get_by_role("button", name="Leave as it is")).to_be_focused()
    hold_enter(page)
    expect(page.get_by_role("button", name="grab: Space")).to_be_focused()
