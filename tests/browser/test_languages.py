"""The start page and the game in another language than English."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.pages import violations
from tests.browser.support import wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
WORDS = Path(__file__).parents[2] / "web" / "words"

# Texts that people see, and labels that screen readers say.
SEEN = """() => {
    const texts = [document.title];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
        const node = walker.currentNode;
        if (node.parentElement.closest("noscript, script, #language")) continue;
        if (node.parentElement.checkVisibility()) texts.push(node.textContent.replace(/\\s+/g, " ").trim());
    }
    for (const element of document.querySelectorAll("[aria-label], [alt], [title]"))
        if (element.checkVisibility())
            texts.push(...["aria-label", "alt", "title"].map((name) => element.getAttribute(name) ?? ""));
    return texts.filter((text) => text !== "");
}"""


def catalogue(language: str) -> dict[str, str]:
    texts: dict[str, str] = json.loads((WORDS / f"{language}.json").read_text(encoding="utf-8"))
    return texts


def english_on(page: Page) -> list[str]:
    """What a German page says in the words of the English catalogue."""
    german = set(catalogue("de").values())
    with_words = re.compile(r"[A-Za-z]{2}")  # beside the places in braces
    texts = [text for text in catalogue("en").values() if with_words.search(re.sub(r"\{\w+\}", "", text))]
    only_english = [text for text in texts if text not in german]
    shapes = [re.compile(re.sub(r"\\\{\w+\\\}", ".+", re.escape(text))) for text in only_english]
    seen: list[str] = page.evaluate(SEEN)
    assert len(seen) > 10
    return [text for text in seen if any(shape.fullmatch(text) for shape in shapes)]


def test_the_check_sees_english(open_page: OpenPage) -> None:
    page = open_page("/?lang=en")
    expect(page.locator("#play")).to_be_enabled()
    assert {"Time limit", "The game", "Play Distance Priority"} <= set(english_on(page))


def test_the_start_page_speaks_the_language_of_its_address(open_page: OpenPage) -> None:
    page = open_page("/?lang=de")
    expect(page.locator("#play")).to_have_text("Nah oder fern spielen")
    page.locator("#more summary").click()
    page.get_by_text("Steuerung", exact=True).click()
    assert english_on(page) == []
    assert violations(page) == []
    page.locator("#seat-1").select_option("link")
    page.locator("#seat-0").select_option("remote")
    page.locator("#play").click()
    expect(page.locator("#share")).to_contain_text("Der Raum ist offen")
    assert english_on(page) == []


def test_the_chosen_language_is_kept_and_goes_into_the_game(open_page: OpenPage) -> None:
    page = open_page("/")
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_label("Sprache")).to_have_value("de")
    expect(page.locator("#practice")).to_be_enabled()
    page.locator("#practice").click()
    page.wait_for_url("**/play/*")
    expect(page.locator("#ready")).to_contain_text("Ich bin bereit")
    assert page.evaluate("document.documentElement.lang") == "de"
    assert english_on(page) == []
    page.get_by_role("button", name="Ich bin bereit").click()
    wait_for(page, "window.__movingout.phase === 'playing'")
    assert english_on(page) == []
    page.keyboard.press("Escape")
    expect(page.locator("#overlay")).to_contain_text("Pause")
    assert english_on(page) == []
    page.get_by_role("button", name="Ändern").click()
    expect(page.locator("#settings")).to_contain_text("Totzone")
    assert english_on(page) == []
    page.get_by_role("button", name="Fertig").click()
    page.get_by_role("button", name="Spiel beenden").click()
    page.get_by_role("button", name="Ja, beenden").click()
    expect(page.locator("#result")).to_contain_text("Sie haben die Runde beendet")
    assert english_on(page) == []


def test_the_language_of_the_address_goes_into_the_game_until_another_is_chosen(open_page: OpenPage) -> None:
    page = open_page("/?lang=de")
    page.locator("#practice").click()
    page.wait_for_url("**/play/*")
    expect(page.locator("#ready")).to_contain_text("Ich bin bereit")
    page.goto(page.url.split("/play/")[0] + "/")
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_label("Language")).to_have_value("en")
    page.reload()
    expect(page.get_by_label("Language")).to_have_value("en")


def test_a_page_that_cannot_be_joined_says_so_in_german(open_page: OpenPage) -> None:
    page = open_page("/play/nowhere?lang=de")
    expect(page.locator("#overlay")).to_contain_text("gibt es nicht")
