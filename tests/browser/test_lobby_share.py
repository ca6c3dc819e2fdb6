"""The page after opening a room for others: how long its link is good for, and how to get back to it."""

from collections.abc import Callable

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.pages import complaining_page, violations
from tests.browser.support import Server
from tests.browser.test_lobby import ready

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]


def share(page: Page, red: str) -> str:
    """Opens a room for somebody with the link and somebody else; its id."""
    ready(page).get_by_role("combobox", name="Blue").select_option("link")
    page.get_by_role("combobox", name="Red").select_option(red)
    page.get_by_role("button", name="Open Distance Priority").click()
    return page.locator(".share-address").inner_text().rsplit("/", 1)[1]


@pytest.mark.parametrize("red", ["link", "remote"])
def test_who_watches_finds_link_and_code_again(open_page: OpenPage, server: Server, red: str) -> None:
    page = open_page("/")
    room = share(page, red)
    page.get_by_role("link", name="Watch the game").click()
    expect(page.locator("#ready")).to_contain_text("Both seats are still free.")
    expect(page.locator("#ready .share-link")).to_have_value(f"{server.url}/play/{room}")
    page.wait_for_function("() => document.querySelector('#ready .qr').naturalWidth > 0")
    assert violations(page) == []


def test_who_watches_sees_where_a_program_connects(open_page: OpenPage, server: Server) -> None:
    room = server.post("/api/rooms", {"maps": ["HandOff"], "seats": [{"kind": "remote"}, {"kind": "remote"}]})
    page = open_page(room["watch_path"])
    expect(page.locator("#ready")).to_contain_text(f"{server.url.replace('http', 'ws')}/ws/{room['room']}")


def test_the_page_says_how_long_a_room_waits_and_when_it_is_gone(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "") as page:
        page.clock.install()
        page.goto("/")
        room = share(page, "link")
        expect(page.locator("#share")).to_contain_text("closes when nobody has come for 5 minutes")
        page.clock.run_for(30_000)
        expect(page.locator("#share .share-address")).to_be_visible()
        server.request(f"/api/admin/rooms/{room}/close", {}, server.admin_token)
        page.clock.run_for(30_000)
        expect(page.get_by_role("alert")).to_contain_text("This room is closed")
        expect(page.locator("#share img")).to_have_count(0)
        page.get_by_role("button", name="Back to the maps").click()
        expect(page.locator("#play")).to_be_visible()
