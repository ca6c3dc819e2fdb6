"""Browsers that lack something: the lowest ones that are named still show a game, and older ones say that they are."""

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.browser.conftest import OpenPage
from tests.browser.support import PHONE, Server, start, wait_for

pytestmark = pytest.mark.slow

# What Safari 15.4 and Chrome 108 do not know yet, as far as a newer browser can forget it.
LOWEST = """delete window.OffscreenCanvas;
  delete CanvasRenderingContext2D.prototype.roundRect;
  delete AbortSignal.timeout;"""
TOO_OLD = "delete window.structuredClone;"
NEWER_CSS = ("color-mix(", "subgrid", "cqh", "@container", "container-type")


def without_newer_css(route: Route) -> None:
    answer = route.fetch()
    css = answer.text()
    for word in NEWER_CSS:
        css = css.replace(word, f"{word[0]}-unknown-{word[1:]}" if word[0] != "@" else "@unknown")
    route.fulfill(response=answer, body=css)


def forget_newer_css(page: Page) -> None:
    page.route("**/*.css", without_newer_css)
    page.reload()


@pytest.mark.parametrize(
    "size",
    [
        pytest.param({"width": 375, "height": 553}, id="small"),
        pytest.param(PHONE, id="phone"),
        pytest.param({"width": 667, "height": 375}, id="across"),
    ],
)
def test_the_lowest_browsers_show_a_round(server: Server, open_page: OpenPage, size: dict[str, int]) -> None:
    room = server.make_room("HandOff", red="idle")
    page = open_page(room["join_path"], room, LOWEST, viewport=size, has_touch=True)
    forget_newer_css(page)
    start(page, tap=True)
    wait_for(page, "game.entities() !== null && game.frames > 5")
    for part in ("#knob", "#touch-grab", "#arena"):
        box = page.locator(part).bounding_box()
        assert box is not None and min(box["width"], box["height"]) >= 44, part
    drawn = "() => new Set(document.querySelector('#arena').getContext('2d').getImageData(0, 0, 150, 150).data).size"
    assert page.evaluate(drawn) > 10


@pytest.mark.parametrize("path", ["/", "/recordings", "/editor", "/watch/nowhere"])
def test_a_browser_that_is_too_old_says_so_in_every_language(browser: Browser, server: Server, path: str) -> None:
    with browser.new_context(base_url=server.url, viewport={"width": 320, "height": 568}) as context:
        context.add_init_script(TOO_OLD)
        page = context.new_page()
        page.goto(path)
        expect(page.get_by_text("This browser is too old for this page.")).to_be_visible()
        expect(page.get_by_text("Dieser Browser ist zu alt für diese Seite.")).to_be_visible()
        expect(page.locator("main")).to_have_count(1)
        assert page.get_by_role("button").count() == 0, "nothing of the page itself is left, or starts"
