"""Pings in two pages: a key, a button and a tap ask for help, both see where, and nothing of it where they are off."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.pages import violations
from tests.browser.support import Server, start, wait_for
from tests.browser.test_layout import Window, in_window

OpenPage = Callable[..., Page]
PHONE = Window(375, 553, True, 330)


def pings(page: Page) -> list[tuple[int, int]]:
    """Seat and item of those that are shown."""
    shown: list[tuple[int, int]] = page.evaluate("window.__movingout.pings().map(({seat, item}) => [seat, item])")
    return [(seat, item) for seat, item in shown]


def tap_item(page: Page, item: int, touch: bool) -> None:
    at: Any = page.evaluate(
        """(item) => {
          const box = document.querySelector("#arena").getBoundingClientRect();
          const {x, y} = window.__movingout.entities().items[item];
          return [box.left + (x + 1.2) / 2.4 * box.width, box.top + (1.2 - y) / 2.4 * box.height];
        }""",
        item,
    )
    if touch:
        page.touchscreen.tap(*at)
    else:
        page.mouse.click(*at)


@pytest.mark.slow
def test_a_key_and_a_tap_ask_for_help_and_both_pages_show_it_for_two_seconds(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.make_room("SequentialRotations")  # the item is far away from both
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    start(blue, red)
    expect(blue.locator("#controls")).to_contain_text("help here")
    blue.keyboard.press("KeyE")
    for page in (blue, red):
        wait_for(page, "game.pings().length === 1")
    assert pings(red) == [(0, -1)]
    expect(red.locator("#live")).to_have_text("Blue asks you to come.")
    tap_item(red, 0, touch=False)
    for page in (blue, red):
        wait_for(page, "game.pings().some(({seat, item}) => seat === 1 && item === 0)")
    expect(blue.locator("#live")).to_have_text("Red needs help with a large item.")
    for name, page in (("pings-blue", blue), ("pings-red", red)):
        page.screenshot(path=pictures / f"{name}.png")
    wait_for(blue, "game.pings().length === 0")
    wait_for(red, "game.pings().length === 0")
    for _ in range(6):
        blue.keyboard.press("KeyE")
    expect(blue.locator("#problem")).to_contain_text("Wait a second")
    wait_for(red, "game.pings().length > 0")
    assert len(pings(red)) <= 3
    assert violations(blue) == []


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone_a_small_button_and_a_tap_on_an_item_do_it(
    server: Server, open_page: OpenPage, pictures: Path, dark: bool
) -> None:
    window = PHONE._replace(dark=dark, language="de-DE" if dark else "en-GB")
    room = server.make_room("TopBottomPriority", red="scripted")
    page = open_page(room["join_path"], room, **in_window(window))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button.button-primary").tap()
    wait_for(page, "game.phase === 'playing'")
    page.locator("#touch-ping").tap()  # the large item is in front
    wait_for(page, "game.pings().some(({seat, item}) => seat === 0 && item === 0)")
    tap_item(page, 1, touch=True)
    wait_for(page, "game.pings().some(({seat, item}) => seat === 0 && item === 1)")
    for _ in range(6):
        page.locator("#touch-ping").tap()
    expect(page.locator("#problem")).to_be_visible()
    problem, arena = page.locator("#problem").bounding_box(), page.locator("#arena").bounding_box()
    assert problem is not None and arena is not None
    assert problem["y"] + problem["height"] <= arena["y"], "the notice covers the arena"
    page.screenshot(path=pictures / f"pings-phone-{'dark' if dark else 'light'}.png")


@pytest.mark.slow
def test_where_pings_are_off_there_is_no_button_no_word_and_no_ping(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("TopBottomPriority", red="idle", pings=False)
    page = open_page(room["join_path"], room, **in_window(PHONE))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button.button-primary").tap()
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("KeyE")
    tap_item(page, 0, touch=True)
    tick = page.evaluate("window.__movingout.tick")
    wait_for(page, f"game.tick > {tick + 5}")
    assert pings(page) == []
    expect(page.locator("#touch-ping")).to_be_hidden()
    expect(page.locator("#problem")).to_be_hidden()
    expect(page.locator("#controls")).not_to_contain_text("help here")


@pytest.mark.slow
def test_with_reduced_motion_the_marker_stands_still(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("TopBottomPriority", red="idle")
    page = open_page(room["join_path"], room, reduced_motion="reduce")
    start(page)
    page.keyboard.press("KeyE")
    wait_for(page, "game.pings().length === 1")
    page.wait_for_timeout(300)  # until it is drawn
    pixels = "() => document.querySelector('#arena').toDataURL()"
    first = page.evaluate(pixels)
    page.wait_for_timeout(300)
    assert page.evaluate(pixels) == first
