"""What the address of the start page asks for: a map, its shuffled items, a partner, a game at once, the tutorial."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.browser.pages import complaining_page, overflow, violations
from tests.browser.support import Server
from tests.browser.test_lobby import ready

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]


def test_the_address_can_name_the_map_and_lead_to_the_choice_of_a_partner(open_page: OpenPage) -> None:
    page = ready(open_page("/?map=LeftRight#partner"))
    expect(page.locator("#chosen h2")).to_have_text("Left Right")
    expect(page.get_by_role("combobox", name="Red")).to_be_focused()


def test_the_address_can_name_a_map_that_stands_in_no_list(open_page: OpenPage, pictures: Path) -> None:
    page = ready(open_page("/?map=HandOff:mirror"))
    expect(page.locator("#chosen h2")).to_have_text("Hand Off, mirrored")
    group = page.locator(".map-group", has=page.get_by_role("heading", name="Linked map"))
    expect(group.get_by_role("radio")).to_be_checked()
    assert violations(page) == []
    page.screenshot(path=pictures / "lobby-linked-map.png")
    page.locator("#seat-1").select_option("agent:idle")
    with page.expect_request("**/api/rooms") as sent:
        page.locator("#play").click()
    assert json.loads(sent.value.post_data or "")["maps"] == ["HandOff:mirror"]


def test_while_the_linked_map_is_made_another_can_be_chosen(open_page: OpenPage) -> None:
    page = open_page("/")
    asked: list[Route] = []
    page.route("**/api/maps/*", lambda route: asked.append(route))  # not answered yet
    page.goto("/?map=HandOff:mirror")
    ready(page).get_by_role("radio", name="Left Right").check(force=True)
    assert len(asked) == 1
    asked[0].continue_()
    expect(page.locator(".map-group").first.get_by_role("heading")).to_have_text("Linked map")
    expect(page.locator("#chosen h2")).to_have_text("Left Right")


def test_of_a_map_that_is_none_it_is_said(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "/?map=MyMap") as page:
        ready(page)
        expect(page.get_by_role("alert").filter(has_text="This server does not have the map MyMap.")).to_be_visible()
        expect(page.locator("#chosen h2")).to_have_text("Distance Priority")


def test_a_long_name_that_is_no_map_makes_no_wide_page(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "/?map=my%2F" + "x" * 3000, viewport={"width": 320, "height": 568}) as page:
        ready(page)
        told = f"This server does not have the map my/{'x' * 56}…."
        expect(page.get_by_role("alert").filter(has_text=told)).to_be_visible()
        assert overflow(page) == 0


def test_a_room_that_does_not_exist_offers_a_game(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "/play/nosuchroom12") as page:
        expect(page.get_by_role("alert").filter(has_text="no longer exists")).to_be_visible()
        assert violations(page) == []
        page.get_by_role("link", name="Play now").click()
        page.wait_for_url(lambda url: "/play/" in url and "nosuchroom" not in url)
        expect(page.get_by_role("button", name="I am ready")).to_be_visible()
        page.go_back()
        expect(page.locator("#play-now")).to_be_enabled()


def test_another_language_keeps_the_map_of_the_address_and_the_number(open_page: OpenPage) -> None:
    page = ready(open_page("/?lang=en&map=HandOff:mirror&seed=7"))
    expect(page.locator("#chosen h2")).to_have_text("Hand Off, mirrored")
    expect(page.locator("#seed")).to_have_value("7")
    page.locator("#language").select_option("de")
    expect(page.get_by_label("Sprache")).to_have_value("de")
    expect(page.locator("#chosen h2")).to_have_text("Übergabe, gespiegelt")
    expect(page.locator("#seed")).to_have_value("7")
    expect(page.locator("#randomised")).to_be_checked()


def test_another_language_keeps_the_chosen_one_of_two_drawings_of_a_name(open_page: OpenPage) -> None:
    """It went from the operator's map, which may be mended, to the drawing that was just played."""
    page = ready(open_page("/"))
    lists = page.evaluate("fetch('/api/maps').then((answer) => answer.json())")
    mended = lists["maps"][0] | {"name": "Garage", "title": "Garage, mended"}
    played = json.dumps(mended | {"title": "Garage, played", "walls": []})
    page.evaluate("map => sessionStorage.setItem('movingout.played', map)", played)
    page.route("**/api/maps", lambda route: route.fulfill(json=lists | {"own": [mended]}))
    page.goto("/?map=Garage")
    title = page.locator("#chosen h2")
    expect(title).to_have_text("Garage, played")
    for language, chosen in [("de", "Garage, mended"), ("en", "Garage, played")]:
        page.get_by_role("radio", name=chosen).check(force=True)
        with page.expect_navigation():
            page.locator("#language").select_option(language)
        expect(page.locator(".map-group").first.get_by_role("radio")).to_have_count(1)
        expect(title).to_have_text(chosen)
        assert "listed" not in page.url  # it goes along where people copy the address
    page.goto("/")
    expect(title).to_have_text("Garage, mended")


def test_who_comes_back_from_the_tutorial_s_address_is_on_the_start_page(open_page: OpenPage) -> None:
    page = open_page("/practice")
    page.wait_for_url("**/play/*")
    page.go_back()
    ready(page)
    assert page.url.endswith("/")


def test_an_address_that_leads_nowhere_has_a_page_with_the_way_back(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "/nowhere") as page:
        page.get_by_role("link", name="To the start page").click()
        ready(page)
