"""What a page loads, and what it says until it has loaded."""

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Route, expect

from tests.browser.study_fake import FakePerson, FakeStudy, consent
from tests.browser.support import PHONE, Server, wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]

# The names of those that were loaded, once each of them and no other was announced.
MODULES = """() => {
  const at = (elements, key) => [...elements].map((one) => one[key]).filter(Boolean).sort();
  const scripts = performance.getEntriesByType("resource").filter(({ name }) => name.endsWith(".js"));
  const links = document.querySelectorAll("[rel=modulepreload]");
  const [announced, loaded] = [[...at(document.scripts, "src"), ...at(links, "href")].sort(), at(scripts, "name")];
  return JSON.stringify(announced) === JSON.stringify(loaded) && loaded;
}"""


@pytest.mark.parametrize("path", ["/", "/editor", "/recordings"])
def test_a_page_announces_every_module_that_it_loads(open_page: OpenPage, path: str) -> None:
    page = open_page(path)
    assert len(page.wait_for_function(MODULES).json_value()) > 10


def test_the_game_says_that_it_connects_until_its_program_is_there(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page("/healthz")
    held: list[Route] = []
    page.route("**/static/play/play.js", lambda route: held.append(route))
    page.goto(room["watch_path"], wait_until="commit")
    expect(page.get_by_text("Connecting…")).to_be_visible()
    expect(page.locator("#stop")).to_be_disabled()  # nothing hears it yet
    held.pop().continue_()
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    expect(page.locator("#overlay")).to_be_hidden()
    expect(page.locator("#stop")).to_be_enabled()


@pytest.mark.parametrize(
    ("locale", "query", "words"),
    [
        ("en-GB", "", "The study is loading…"),
        ("de-AT", "", "Die Studie wird geladen …"),
        ("fr", "", "The study is loading…"),
        ("en", "?lang=de", "Die Studie wird geladen …"),
    ],
)
def test_a_study_says_that_it_loads_in_the_readers_language_before_any_text_is_there(
    open_page: OpenPage, locale: str, query: str, words: str
) -> None:
    page = open_page("/healthz", locale=locale, viewport=PHONE)
    held: list[Route] = []
    page.route("**/*.js*", lambda route: held.append(route) if "/study/" in route.request.url else route.fallback())
    study = FakeStudy(coming=[FakePerson([consent()])])
    study.install(page)
    page.goto("/study" + query, wait_until="commit")
    expect(page.get_by_role("status").filter(visible=True)).to_have_text(words, use_inner_text=True)
    before = page.locator("#study-screen").bounding_box()
    page.unroute("**/*.js*")
    for route in held:
        route.fallback()
    expect(page.get_by_role("heading")).to_be_visible()
    after = page.locator("#study-screen").bounding_box()
    assert before is not None and after is not None
    assert (after["x"], after["y"], after["width"]) == (before["x"], before["y"], before["width"])
