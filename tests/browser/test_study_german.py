"""A whole German study at a real server: no screen has an English word, and every screen fits a small phone."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from movingout.study.design.instruments import instrument, instrument_names
from movingout.study.design.translations import page_words
from tests.browser.pages import overflow, violations
from tests.browser.study_participant import KeyboardParticipant
from tests.browser.study_served import served_study
from tests.browser.support import DESKTOP
from tests.server.study_bots.support import agents_text

SMALL = {"width": 375, "height": 553}
NARROW = {"width": 360, "height": 640}
ONE_PARTNER = (
    ("[helper, still]", "[helper]"),
    ("  - {id: still, agent: idle}\n", ""),
)
SEEN = (
    "() => document.body.innerText + [...document.querySelectorAll('[aria-label]')].map(one => one.ariaLabel).join(' ')"
)


def words_of(language: str) -> set[str]:
    """Every word that the pages and the ready-made questionnaires use in a language."""
    texts = [re.sub(r"\{\w+\}", " ", text) for text in (page_words(language) or {}).values()]
    for name in instrument_names():
        form = instrument(name, language)
        texts.append(form.title)
        for item in form.items:
            texts += [item.text, *item.options, *item.ends]
    return {word for text in texts for word in words_in(text)}


def words_in(text: str) -> set[str]:
    return {word.lower() for word in re.findall(r"[^\W\d_]{2,}", text)}


@pytest.mark.slow
def test_nobody_who_speaks_german_reads_english_on_any_screen(browser: Browser, tmp_path: Path, pictures: Path) -> None:
    text = agents_text(ticks=30)
    for old, new in ONE_PARTNER:
        text = text.replace(old, new)
    english = words_of("en") - words_of("de") - {"english"}  # the name of a language in the choice of languages
    with served_study(tmp_path, text, browser) as study:
        page = study.page("/study?lang=de", locale="de-DE")
        found: dict[str, set[str]] = {}
        looked: set[str] = set()

        def look(kind: str) -> None:
            strange = words_in(page.evaluate(SEEN)) & english
            found[kind] = found.get(kind, set()) | strange
            screen = page.evaluate("document.querySelector('#study-screen')?.dataset.key") or kind
            if screen in looked:
                return
            looked.add(screen)
            if kind.startswith(("in ", "after ")):
                page.screenshot(path=pictures / f"german-{kind.replace(' ', '-')}.png")
                return  # the game page is tried by its own tests
            for size in (SMALL, NARROW):
                page.set_viewport_size(size)  # type: ignore[arg-type]
                assert overflow(page) == 0, kind
                page.screenshot(path=pictures / f"german-{kind}-{size['width']}.png", full_page=True)
            page.set_viewport_size(DESKTOP)  # type: ignore[arg-type]
            assert violations(page) == [], kind

        person = KeyboardParticipant(page, look, "de")
        page.wait_for_selector("#study-screen h1")
        look("arrival")
        person.press(person.words["study.arrival.begin"])
        page.wait_for_selector("#study-screen[data-kind=consent]")
        person.walk()
        assert page.evaluate("document.documentElement.lang") == "de"
        assert set(found) == {
            *(
                "arrival",
                "consent",
                "form",
                "input-check",
                "practice",
                "in practice",
                "round",
                "in a round",
                "after a round",
            ),
            *("break", "questionnaire", "debrief", "code"),
        }
        assert {kind: words for kind, words in found.items() if words} == {}
        assert study.complaints() == []
