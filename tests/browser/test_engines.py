"""Chromium, Firefox and WebKit each play a round beside the scripted partner and the tutorial, and fill in a form."""

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser

from tests.browser.engines import Tab, click_on, missing, open_tab, press, take_seats, wait_until
from tests.browser.newcomer import SIGHT, Direction, Newcomer
from tests.browser.support import Server, free_port, start_process
from tests.server.study_bots.support import agents_text

pytestmark = pytest.mark.slow
AGAIN_S = 2.0  # a page that lost the focus let go of all keys: people press again


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


class Hands(Newcomer):
    """A newcomer at the keyboard of any engine."""

    def __init__(self, tab: Tab) -> None:
        self.tab = tab
        self._down: set[str] = set()
        self._changed_at = 0.0
        self._grabbed_at = 0.0

    def look(self) -> dict[str, Any]:
        seen: dict[str, Any] = self.tab.evaluate("window.__sight()")
        return seen

    def push(self, direction: Direction = (0.0, 0.0), backward: bool = False) -> None:
        right, down = direction
        letter = ("d" if right > 0 else "a") if abs(right) > abs(down) else ("s" if down > 0 else "w")
        moves = {letter} if direction != (0.0, 0.0) else set[str]()  # WebKit's driver holds one letter at a time
        wanted = moves | ({"Shift"} if backward else set[str]())
        if wanted == self._down and time.monotonic() - self._changed_at < AGAIN_S:
            return
        # Drivers know a letter by how it was typed: it has to come up with Shift as it went down.
        anew = wanted == self._down or "Shift" in wanted ^ self._down
        gone, new = (self._down, wanted) if anew else (self._down - wanted, wanted - self._down)
        for key in sorted(gone, reverse=True):
            self.tab.key(key, False)
        for key in sorted(new):
            self.tab.key(key, True)
        self._down, self._changed_at = wanted, time.monotonic()

    def grab(self) -> None:
        if time.monotonic() - self._grabbed_at < 0.7:
            return
        self._grabbed_at = time.monotonic()
        self.push()
        press(self.tab, "Space")
        time.sleep(0.25)


def test_an_engine_teaches_the_tutorial_to_a_newcomer(server: Server, tab: Tab) -> None:
    room = server.post("/api/rooms", {"tutorial": True})
    take_seats(tab, server.url, room, "playing")
    tab.evaluate(f"void (() => {{ {SIGHT}\n}})()")
    heard = Hands(tab).play()
    starts = ["Drive into", "Drive up to", "Bring it", "Drive backward", "A 2 needs", "Well done"]
    assert [words.startswith(start) for words, start in zip(heard, starts, strict=True)] == [True] * 6, heard
    assert tab.evaluate("document.querySelector('.overlay-end h2').textContent") == "You are ready to play"
    click_on(tab, ".overlay-end button")  # once more
    wait_until(tab, "window.__movingout.phase === 'playing'")


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
