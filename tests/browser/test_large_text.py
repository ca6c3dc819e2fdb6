"""Letters of twice the size (WCAG 1.4.4), as browsers offer for text alone: nothing lies over anything."""

import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from movingout.recordings import finalise
from tests.browser import study_fake as fake
from tests.browser.pages import admin_token, overflow
from tests.browser.study_fake import FakeStudy
from tests.browser.support import Server, wait_for
from tests.recordings.support import record

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
CUT = "all => all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.textContent)"

TWICE = """() => {
  const all = [...document.querySelectorAll("body, body *")];
  const sizes = all.map((one) => parseFloat(getComputedStyle(one).fontSize));
  all.forEach((one, index) => { one.style.fontSize = `${2 * sizes[index]}px`; });
}"""
# The same in the style sheets, so that a page may still shrink letters.
TWICE_IN_SHEETS = """() => {
  const enlarge = (rules) => [...rules].forEach((rule) => {
    const { font = "", fontSize = "" } = rule.style ?? {};
    if (fontSize.includes("px")) rule.style.fontSize = `calc(2 * (${fontSize}))`;
    else if (font.includes("px")) rule.style.font = font.replace(/[0-9]+px/, (size) => `${2 * parseFloat(size)}px`);
    else enlarge(rule.cssRules ?? []);
  });
  [...document.styleSheets].forEach((sheet) => enlarge(sheet.cssRules));
  document.body.style.fontSize = "32px"; // no rule can tell its own, in a `font` with a variable
}"""
# Words of a text that take more lines than their soft hyphens allow.
BROKEN = """(one) => [...one.firstChild.data.matchAll(/\\S+/g)].filter(({ 0: word, index }) => {
  const range = document.createRange();
  range.setStart(one.firstChild, index);
  range.setEnd(one.firstChild, index + word.length);
  return new Set([...range.getClientRects()].map(({ top }) => top)).size > word.split("\u00ad").length;
}).map(([word]) => word)"""
# Pairs of texts of which one covers the other; what is scrolled out of sight or cut off covers nothing.
COVERED = """() => {
  const inSight = (element, { left, top, right, bottom }) => {
    for (let one = element; one; one = one.parentElement) {
      if (getComputedStyle(one).overflowX === "visible") continue;
      const frame = one.getBoundingClientRect();
      left = Math.max(left, frame.left);
      right = Math.min(right, frame.right);
      top = Math.max(top, frame.top);
      bottom = Math.min(bottom, frame.bottom);
    }
    return { left, top, right, bottom };
  };
  const texts = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode()); ) {
    const parent = node.parentElement;
    if (!node.data.trim() || !parent.checkVisibility() || parent.closest(".sr-only, option, noscript")) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) texts.push({ node, box: inSight(parent, box) });
  }
  const covered = [];
  texts.forEach((one, index) => texts.slice(index + 1).forEach((other) => {
    if (one.node === other.node) return;
    const wide = Math.min(one.box.right, other.box.right) - Math.max(one.box.left, other.box.left);
    const high = Math.min(one.box.bottom, other.box.bottom) - Math.max(one.box.top, other.box.top);
    if (wide > 3 && high > 5) covered.push(`${one.node.data.trim()} / ${other.node.data.trim()}`);
  }));
  return covered;
}"""
PHONE: dict[str, Any] = {"viewport": {"width": 375, "height": 553}, "has_touch": True}
WINDOW: dict[str, Any] = {"viewport": {"width": 1280, "height": 800}}


def faults(page: Page) -> list[str]:
    page.evaluate(TWICE)
    covered: list[str] = page.evaluate(COVERED)
    return covered + [f"{too_wide} px too wide" for too_wide in [overflow(page)] if too_wide > 0]


@pytest.mark.parametrize("window", [PHONE, WINDOW], ids=["phone", "desktop"])
def test_every_page_beside_the_game_can_be_read(server: Server, open_page: OpenPage, window: dict[str, Any]) -> None:
    episode = f"large-{window['viewport']['width']}"
    ended: dict[str, Any] = {"outcome": "left", "map_name": "SequentialRotations"}
    finalise(record(server.data / "recordings", ticks=60, episode_id=episode, **ended)[0])
    room = server.make_room("Simple", blue="idle", red="idle", limit_ticks=30)
    token = f"sessionStorage.setItem('movingout.admin', '{admin_token(server)}')"
    ready = {
        room["watch_path"]: "#result h2",
        "/recordings": "#rows tr",
        f"/replay/{episode}": "#events li",
        "/editor": "#arena",
        "/admin": "[data-room]",
    }
    wrong = {}
    for path, selector in ready.items():
        page = open_page("/healthz", None, f"if (location.protocol !== 'about:') {token}", **window)
        page.goto(f"{path}?lang=de")
        expect(page.locator(selector).first).to_be_visible(timeout=30_000)
        for summary in page.locator("summary:visible").all():
            summary.click()
        wrong[path] = faults(page)
        page.context.close()
    assert wrong == {path: [] for path in ready}


def test_where_controls_are_tried_the_name_of_the_device_covers_no_word(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check(), fake.code())
    page = open_page("/healthz", **PHONE)
    study.open(page)
    expect(page.locator(".check-panel .pill")).to_be_visible()
    pill, up = page.locator(".check-panel .pill"), page.locator(".check-up")
    assert pill.evaluate("one => getComputedStyle(one.parentElement).position") == "absolute"  # beside the cross
    assert faults(page) == []
    boxes = [one.bounding_box() for one in (pill, up)]
    assert boxes[0] and boxes[1] and boxes[0]["y"] + boxes[0]["height"] <= boxes[1]["y"]


@pytest.mark.parametrize("language", ["en", "de"])
def test_on_the_narrowest_screen_maps_are_chosen_and_drawn_without_scrolling_to_the_side(
    open_page: OpenPage, language: str
) -> None:
    for path, selector in {"/": ".map canvas", "/editor": "#arena"}.items():
        page = open_page(f"{path}?lang={language}", None, viewport={"width": 320, "height": 568}, has_touch=True)
        expect(page.locator(selector).first).to_be_visible()
        expect(page.locator("html")).to_have_attribute("lang", language)
        columns = "maps => new Set(maps.map((map) => map.getBoundingClientRect().left)).size"
        assert path != "/" or page.locator(".map").evaluate_all(columns) == 2, "letters of the usual size"
        page.evaluate(TWICE)
        assert overflow(page) <= 0, path


def test_on_the_narrowest_screen_no_word_of_the_title_is_broken(open_page: OpenPage) -> None:
    page = open_page("/?lang=de", None, viewport={"width": 320, "height": 568}, has_touch=True)
    title, choice = page.locator("h1"), page.locator("#language")
    expect(page.locator(".map canvas").first).to_be_visible()
    beside = "([one, other]) => one.getBoundingClientRect().bottom > other.getBoundingClientRect().top"
    assert page.evaluate(beside, [title.element_handle(), choice.element_handle()]), "letters of the usual size"
    page.evaluate(TWICE)
    assert title.evaluate(BROKEN) == []
    assert overflow(page) <= 0
    assert page.locator("h1, #language").evaluate_all(CUT) == []


@pytest.mark.parametrize("has_touch", [True, False])
def test_in_low_windows_and_on_tablets_letters_of_the_usual_size_leave_the_words_of_the_score_whole(
    server: Server, open_page: OpenPage, has_touch: bool
) -> None:
    room = server.practice()
    page = open_page(f"/play/{room['room']}?lang=de", room, has_touch=has_touch, is_mobile=has_touch)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    low = ((568, 320), (553, 375), (500, 300), (480, 320), (640, 450), (720, 520), (932, 430))
    for width, height in (*low, (1024, 768)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.locator("#done")).to_have_text("0 / 3")
        assert page.locator(".meter .label").evaluate_all(CUT) == [], (width, height)


def test_in_a_round_figures_and_buttons_stay_in_their_places(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(f"/play/{room['room']}?lang=de", room, **PHONE)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.get_by_role("button", name="Ich bin bereit").click()
    wait_for(page, "game.phase === 'playing'")
    for width in (360, 375, 390):  # letters of the usual size: every word is whole
        page.set_viewport_size({"width": width, "height": 640})
        assert page.locator(".meter .label").evaluate_all(CUT) == [], width
    page.set_viewport_size(PHONE["viewport"])
    assert faults(page) == []
    for part in ("#time", "#done", "#touch-grab", "#touch-backward"):
        assert page.locator(part).evaluate("one => one.scrollWidth <= one.clientWidth"), part
    boxes = [page.locator(part).bounding_box() for part in ("#time", "#done", "#mute")]
    for left, right in pairwise(boxes):
        assert left and right and left["x"] + left["width"] <= right["x"]


@pytest.mark.parametrize("language", ["en", "de"])
def test_on_the_narrowest_screen_what_is_delivered_is_said_in_a_whole_word(
    server: Server, open_page: OpenPage, language: str
) -> None:
    room = server.practice()
    page = open_page(f"/play/{room['room']}?lang={language}", room, has_touch=True, is_mobile=True)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.evaluate(TWICE_IN_SHEETS)
    for size in ({"width": 340, "height": 568}, {"width": 320, "height": 568}, {"width": 320, "height": 480}):
        page.set_viewport_size(size)  # type: ignore[arg-type]
        expect(page.locator("#done-label")).to_have_css("--fit", re.compile(r"0\.[4-9]\d?"))
        assert page.locator("#done-label, #done, #time").evaluate_all(CUT) == []
    assert page.locator("#done-label").evaluate("one => parseFloat(getComputedStyle(one).fontSize)") > 14


@pytest.mark.parametrize("has_touch", [True, False])
def test_on_the_narrowest_screen_what_players_do_stays_in_its_line(
    server: Server, open_page: OpenPage, has_touch: bool
) -> None:
    room = server.make_room("AdaptiveAssist", red="scripted")
    small = {"viewport": {"width": 320, "height": 568}, "has_touch": has_touch, "is_mobile": has_touch}
    page = open_page(f"{room['join_path']}?lang=de", room, **small)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button.button-primary").click()
    wait_for(page, "game.phase === 'playing'")
    assert faults(page) == []
    time, label = (page.locator(part).bounding_box() for part in ("#time", "#done-label"))
    assert time and label and time["x"] + time["width"] + 4 <= label["x"]
    line, arena = (page.locator(part).bounding_box() for part in ("#seats", "#arena"))
    assert line and arena and line["y"] + line["height"] <= arena["y"]
    for words in page.locator("#seats .seat-words").all():
        box, size = words.bounding_box(), words.evaluate("one => parseFloat(getComputedStyle(one).fontSize)")
        assert box and line["y"] <= box["y"] and box["y"] + box["height"] <= line["y"] + line["height"]
        assert words.evaluate("one => parseFloat(getComputedStyle(one).lineHeight)") >= size


@pytest.mark.parametrize("language", ["en", "de"])
def test_on_the_narrowest_screen_the_names_of_players_cover_neither_the_time_nor_the_arena(
    server: Server, open_page: OpenPage, language: str
) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    page = open_page(f"{room['join_path']}?lang={language}", room, has_touch=True, is_mobile=True)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    names, line = page.locator(".seat-name"), page.locator("#seats")
    expect(names.first).to_have_text(re.compile("·"))  # the device is told, too
    for width in (375, 320):
        page.set_viewport_size({"width": width, "height": 568})
        expect(line).to_have_css("--fit", "1.00")
    page.evaluate(TWICE_IN_SHEETS)
    page.set_viewport_size({"width": 340, "height": 568})
    page.set_viewport_size({"width": 320, "height": 568})
    expect(line).to_have_css("--fit", re.compile(r"0\.[5-9]\d?"))
    bounds = line.bounding_box()
    for name in names.all():
        box = name.bounding_box()
        assert bounds and box and bounds["y"] <= box["y"]
        assert box["y"] + box["height"] <= bounds["y"] + bounds["height"]
        assert name.evaluate(BROKEN) == []
        assert name.evaluate("one => parseFloat(getComputedStyle(one).fontSize)") > 14


def test_after_a_phone_is_turned_in_a_round_what_is_said_of_the_connection_stays_in_its_column(
    server: Server, open_page: OpenPage
) -> None:
    room = server.practice()
    page = open_page(f"/play/{room['room']}?lang=de", room, has_touch=True, is_mobile=True)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.set_viewport_size({"width": 568, "height": 320})
    pill, card = page.locator("#connection"), page.locator(".play-connection")
    expect(pill).to_have_text(re.compile("ms"))
    assert pill.evaluate("one => parseFloat(getComputedStyle(one).fontSize)") == 13
    page.set_viewport_size({"width": 320, "height": 568})
    page.evaluate(TWICE_IN_SHEETS)
    page.locator("#ready button.button-primary").click()
    wait_for(page, "game.phase === 'playing'")
    page.set_viewport_size({"width": 568, "height": 320})
    expect(pill.locator("..")).to_have_css("--fit", re.compile(r"0\.[5-9]\d?"))
    assert page.evaluate("Math.max(innerWidth, document.documentElement.scrollWidth)") == 568
    outer, inner = card.bounding_box(), pill.bounding_box()
    assert outer and inner and outer["x"] <= inner["x"]
    assert inner["x"] + inner["width"] <= outer["x"] + outer["width"]
    assert page.locator("#connection").evaluate_all(CUT) == []
