"""Chromium, Firefox and WebKit each play a round beside the scripted partner and fill in a questionnaire."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.browser.engines import Tab, click_on, missing, open_tab, press, take_seats, wait_until
from tests.browser.support import Server, free_port, start_process
from tests.server.study_bots.support import agents_text

pytestmark = pytest.mark.slow


@pytest.fixture(params=["chromium", "firefox", "webkit"])
def tab(request: pytest.FixtureRequest, browser: Browser) -> Iterator[Tab]:
    """A tab of each engine; without the engine the test is skipped, in continuous integration it fails."""
    sentence = missing(request.param)
    if sentence:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(sentence)
    with open_tab(request.param, browser) as opened:
        yield opened


def test_an_engine_plays_a_round_beside_the_scripted_partner(server: Server, tab: Tab) -> None:
    take_seats(tab, server.url, server.make_room("DistancePriority", red="scripted", limit_ticks=400))
    assert tab.evaluate("document.documentElement.scrollHeight <= innerHeight")
    click_on(tab, "#ready button")
    wait_until(tab, "window.__movingout.phase === 'playing'")
    assert tab.evaluate("document.querySelector('#arena').getBoundingClientRect().bottom <= innerHeight")
    here = "window.__movingout.entities().robots[0]"
    before = tab.evaluate(here)
    press(tab, "w", hold_s=1.0)
    after = tab.evaluate(here)
    assert after["y"] > before["y"] + 0.05, "W drives up"
    wait_until(tab, "window.__movingout.entities().items.some((item) => item.delivered)")
    wait_until(tab, "window.__movingout.phase.endsWith('_over')", 90)
    wait_until(tab, "document.querySelector('#result h2')?.checkVisibility()")
    assert tab.evaluate("window.__movingout.result.delivered") > 0


@pytest.fixture
def study(tmp_path: Path) -> Iterator[Server]:
    file = tmp_path / "study.yaml"
    file.write_text(agents_text(), encoding="utf-8")
    served = Server(f"http://127.0.0.1:{free_port()}", tmp_path / "data", tmp_path / "server.log")
    process = start_process(served, "study", "serve", str(file))
    yield served
    process.terminate()
    process.wait(30)


def test_an_engine_fills_in_a_questionnaire(study: Server, tab: Tab) -> None:
    tab.goto(study.url + "/?PROLIFIC_PID=person-1")
    screen = "document.querySelector('#study-screen')"
    wait_until(tab, f"{screen}.dataset.kind === 'consent'")
    for number in range(tab.evaluate(f"{screen}.querySelectorAll('input[type=checkbox]').length")):
        tab.evaluate(f"{screen}.querySelectorAll('input[type=checkbox]')[{number}].setAttribute('data-now', '')")
        click_on(tab, "[data-now]")
        assert tab.evaluate("document.querySelector('[data-now]').checked")
        tab.evaluate("document.querySelector('[data-now]').removeAttribute('data-now')")
    click_on(tab, "#study-screen .button-primary")
    wait_until(tab, f"{screen}.dataset.kind === 'form'")
    asked = 0
    while tab.evaluate(f"{screen}.dataset.kind") == "form":
        asked += answer_page(tab)
        where = tab.evaluate("document.querySelector('.heading')?.textContent")
        click_on(tab, "#study-screen .button-primary")
        wait_until(tab, f"document.querySelector('.heading')?.textContent !== {where!r}")
    assert asked > 0
    wait_until(tab, f"{screen}.dataset.kind === 'input-check'")


def answer_page(tab: Tab) -> int:
    """The first choice of each question that is shown, by a click; the number of questions."""
    count: int = tab.evaluate("document.querySelectorAll('.question').length")
    for number in range(count):
        tab.evaluate(f"document.querySelectorAll('.question')[{number}].setAttribute('data-now', '')")
        field = "[data-now] textarea" if tab.evaluate("!!document.querySelector('[data-now] textarea')") else ""
        click_on(tab, field or "[data-now] label:has(input)")
        if field:
            press(tab, "a")
        else:
            wait_until(tab, "document.querySelector('[data-now] input:checked')")
        tab.evaluate("document.querySelector('[data-now]').removeAttribute('data-now')")
        time.sleep(0.05)
    return count
