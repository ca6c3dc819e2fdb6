"""The operator's own maps in the lobby: `movingout play --maps DIR`."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from movingout.maps import load_map, map_to_json
from tests.browser.pages import complaining_page, overflow, violations
from tests.browser.support import Server, free_port, start, start_process

pytestmark = pytest.mark.slow

GARAGE = map_to_json(load_map("Simple")) | {"name": "Garage", "title": "Die <b>große</b> Garage", "number": 0}


@pytest.fixture(scope="module")
def garage(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server with one good map and one broken file."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "maps").mkdir()
    (folder / "maps" / "garage.json").write_text(json.dumps(GARAGE), encoding="utf-8")
    (folder / "maps" / "half.json").write_text('{"format": 1', encoding="utf-8")
    server = Server(f"http://127.0.0.1:{free_port()}", folder / "data", folder / "server.log")
    process = start_process(server, "play", "--countdown", "1", "--processes", "1", "--maps", str(folder / "maps"))
    yield server
    process.terminate()
    process.wait(timeout=20)


def test_own_maps_stand_in_the_lobby_and_are_played(browser: Browser, garage: Server, pictures: Path) -> None:
    with complaining_page(browser, garage, "/") as page:
        group = page.locator(".map-group", has=page.get_by_role("heading", name="Yours"))
        expect(group.locator(".map-title")).to_have_text(["Die <b>große</b> Garage"])
        expect(group.locator(".map-note")).to_contain_text("One file of the folder is left out")
        assert violations(page) == []
        group.scroll_into_view_if_needed()
        page.screenshot(path=pictures / "lobby-own-maps.png")
        page.get_by_role("radio", name="Garage").check(force=True)
        page.get_by_role("combobox", name="Red").select_option("agent:idle")
        page.locator("#play").click()
        page.wait_for_url("**/play/*")
        start(page)
        assert page.evaluate("window.__movingout.entities().items.length") == len(GARAGE["items"])


def test_they_fit_a_phone_in_german(browser: Browser, garage: Server, pictures: Path) -> None:
    phone = {"width": 375, "height": 553}
    with complaining_page(browser, garage, "/?lang=de", viewport=phone) as page:
        group = page.locator(".map-group", has=page.get_by_role("heading", name="Eigene"))
        group.scroll_into_view_if_needed()
        expect(group.locator(".map-note")).to_contain_text("Eine Datei des Ordners fehlt hier")
        assert overflow(page) <= 0
        page.screenshot(path=pictures / "lobby-own-maps-phone.png")


def test_the_start_says_what_is_offered_and_what_is_left_out(garage: Server) -> None:
    said = garage.log.read_text()
    assert "own map left out: half.json is not JSON" in said
    assert "Your maps    1 in the lobby" in said


def test_a_drawn_map_of_a_listed_name_stays_itself(browser: Browser, garage: Server) -> None:
    """Play again and Another partner: the operator's map of that name has more items than the drawn one."""
    items = "window.__movingout.entities().items.length"
    with complaining_page(browser, garage, "/editor") as page:
        page.get_by_label("Title").fill("Garage")
        expect(page.locator("#verdict")).to_have_text("This map can be played.", timeout=20_000)
        page.locator("#play").click()
        stop_round(page)
        page.get_by_role("button", name="Play again").click()
        page.get_by_role("button", name="I am ready").wait_for()
        stop_round(page)
        assert page.evaluate(items) == 1 < len(GARAGE["items"])
        page.get_by_role("link", name="Another partner").click()
        group = page.locator(".map-group", has=page.get_by_role("heading", name="Just played"))
        expect(group.locator(".map-title")).to_have_text(["Garage"])
        expect(group.get_by_role("radio")).to_be_checked()
        page.get_by_role("radio", name="große").check(force=True)  # the operator's, which they may have mended
        expect(page.locator("#chosen h2")).to_have_text("Die <b>große</b> Garage")
        group.get_by_role("radio").check(force=True)
        expect(page.locator("#chosen h2")).to_have_text("Garage")
        page.get_by_role("combobox", name="Red").select_option("agent:idle")
        page.locator("#play").click()
        start(page)
        assert page.evaluate(items) == 1


def stop_round(page: Page) -> None:
    start(page)
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").click()
    page.get_by_role("button", name="Yes, stop").click()
