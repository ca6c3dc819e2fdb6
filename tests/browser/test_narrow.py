"""No page is wider than 320 pixels (WCAG 1.4.10), in English and in German: nothing has to be scrolled to the side."""

import os
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from movingout.maps import load_map, map_to_json
from movingout.recordings import finalise
from movingout.study.design.instruments import DEMOGRAPHICS
from movingout.study.questionnaire import PAPER
from tests.browser import study_fake
from tests.browser.install import find_chromium
from tests.browser.pages import admin_token, complaining_page, overflow
from tests.browser.study_fake import FakeStudy
from tests.browser.support import FLAGS, Server, start, wait_for
from tests.browser.test_layout import CUT_OFF, PARTS, THUMBS, Window, apart, assert_inside, in_window, scrolls
from tests.browser.test_study_experimenter import UNLOCKED, FakeDashboard
from tests.recordings.support import record

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]

LANGUAGES = ("en", "de")
SMALL: dict[str, Any] = {"viewport": {"width": 320, "height": 568}, "is_mobile": True, "has_touch": True}
WIDER = """[...document.querySelectorAll("body *")]
  .filter((one) => one.checkVisibility() && one.getBoundingClientRect().right > 321)
  .map((one) => one.outerHTML.slice(0, 120)).slice(0, 5)"""


TWO_FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def assert_narrow(page: Page, what: str) -> None:
    # A page that is too wide makes the layout viewport of a phone wider.
    width = page.evaluate("Math.max(innerWidth, document.documentElement.scrollWidth)")
    assert width == 320, (what, page.evaluate(WIDER))
    assert overflow(page) == 0, what


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_page_is_wider_than_a_small_phone(server: Server, open_page: OpenPage, language: str) -> None:
    episode = f"narrow-{language}"
    ended: dict[str, Any] = {"outcome": "left", "map_name": "SequentialRotations"}
    finalise(record(server.data / "recordings", ticks=5, episode_id=episode, **ended)[0])
    room = server.make_room("SequentialRotations", red="link")
    token = f"sessionStorage.setItem('movingout.admin', '{admin_token(server)}')"
    script = f"if (location.protocol !== 'about:') {token}"
    ready = {
        "/": ".map canvas",
        "/admin": "[data-room]",
        "/recordings": "#rows tr",
        f"/replay/{episode}": "#replay",
        room["watch_path"]: "#ready h2",
        room["join_path"]: "#ready h2",
    }
    for path, selector in ready.items():
        page = open_page("/healthz", room if path == room["join_path"] else None, script, **SMALL)
        page.goto(f"{path}?lang={language}")
        expect(page.locator(selector).first).to_be_visible(timeout=30_000)
        page.evaluate(TWO_FRAMES)
        assert_narrow(page, path)
        for summary in page.locator("summary:visible").all():
            summary.click()
        assert_narrow(page, f"{path}, unfolded")
        page.context.close()


def test_the_page_that_does_not_exist_is_no_wider(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "/nosuchpage", **SMALL) as page:
        expect(page.get_by_role("link").first).to_be_visible()
        assert_narrow(page, "/nosuchpage")


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_view_of_a_game_is_wider_than_a_small_phone(server: Server, open_page: OpenPage, language: str) -> None:
    room = server.make_room("AdaptiveAssist", red="idle", limit_ticks=30)
    page = open_page("/healthz", room, **SMALL)
    page.goto(f"{room['join_path']}?lang={language}")
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button").first.tap()
    wait_for(page, "game.phase === 'playing'")
    assert_narrow(page, "playing")
    page.locator("#stop").tap()
    wait_for(page, "game.phase === 'paused'")
    assert_narrow(page, "paused")
    page.locator("#overlay button").first.tap()
    wait_for(page, "game.phase.endsWith('_over')")
    expect(page.locator("#result h2")).to_be_visible()
    assert_narrow(page, "result")


def test_a_drawn_map_with_a_title_of_one_long_word_widens_no_view_of_its_game(
    server: Server, open_page: OpenPage
) -> None:
    drawn = map_to_json(load_map("Simple")) | {"name": "Drawn", "title": "Wohnungs" + "w" * 50, "number": 0}
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    room = server.post("/api/rooms", {"maps": [], "map": drawn, "seats": seats, "limit_ticks": 10})
    page = open_page(room["join_path"], room, **SMALL)
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    assert_narrow(page, "before the round")
    page.locator("#ready button").first.tap()
    wait_for(page, "game.phase.endsWith('_over')")
    expect(page.locator("#result h2")).to_be_visible()
    assert_narrow(page, "result")


@pytest.mark.parametrize(
    "window",
    [
        Window(320, 225, False, 180, "de-DE"),  # 1280 by 900 at a zoom of 400 %
        Window(412, 350, True, 160, "de-DE"),  # a phone that shows two programs
    ],
    ids=str,
)
def test_the_smallest_windows_hold_a_round(server: Server, open_page: OpenPage, window: Window) -> None:
    room = server.make_room("AdaptiveAssist", red="scripted")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button").scroll_into_view_if_needed()
    assert not scrolls(page), "only what is asked scrolls"
    assert_inside(page, "#ready")
    page.locator("#ready button").click()
    wait_for(page, "game.phase === 'playing' && game.tick > 1")
    assert not scrolls(page)
    boxes = [assert_inside(page, part) for part in ["#mute", *PARTS, *(THUMBS if window.touch else [])]]
    assert all(apart(one, other) for index, one in enumerate(boxes) for other in boxes[:index])
    left, _, right, _ = assert_inside(page, "#arena")
    assert right - left >= window.arena
    page.locator("#stop").click()
    wait_for(page, "game.phase === 'paused'")
    assert not scrolls(page)
    page.locator("#overlay button").last.scroll_into_view_if_needed()
    assert_inside(page, "#overlay button:last-of-type")


LINES = """box => {
  const words = document.createRange();
  words.selectNodeContents(box);
  return new Set([...words.getClientRects()].map(({ top }) => top)).size;
}"""
LARGE_TEXT = """
  .touch-grab#touch-grab { font-size: calc(40px * var(--fit, 1)); }
  .touch-backward#touch-backward { font-size: calc(27px * var(--fit, 1)); }"""  # twice what it is


@pytest.mark.parametrize("height", [568, 480])
def test_the_words_on_the_buttons_for_fingers_can_be_read_with_text_at_200_percent(
    server: Server, open_page: OpenPage, height: int
) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    page = open_page("/healthz", room, **{**SMALL, "viewport": {"width": 320, "height": height}})
    page.route(
        "**/touch.css", lambda route: route.fulfill(body=route.fetch().text() + LARGE_TEXT, content_type="text/css")
    )
    page.goto(f"{room['join_path']}?lang=de")
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.locator("#ready button").first.tap()
    wait_for(page, "game.phase === 'playing'")
    page.evaluate(TWO_FRAMES)
    for button, least in (("#touch-grab", 22), ("#touch-backward", 12)):
        box = page.locator(button)
        assert box.evaluate(LINES) == 1, f"{button}: a word is broken"
        cut = box.evaluate("box => [box.scrollHeight - box.clientHeight, box.scrollWidth - box.clientWidth]")
        assert cut == [0, 0], button
        assert box.evaluate("box => parseFloat(getComputedStyle(box).fontSize)") >= least, button


@pytest.mark.parametrize("size", [(375, 553), (320, 568)], ids=str)
def test_words_about_the_connection_cross_no_line_of_the_stick_s_zone(
    server: Server, open_page: OpenPage, size: tuple[int, int]
) -> None:
    room = server.make_room("Simple", red="idle")
    page = open_page(room["join_path"], room, **in_window(Window(*size, True, 0)))
    start(page, tap=True)
    words = "pill.className = 'pill pill-bad'; pill.textContent = 'stockt'"
    measured = f"""pill => {{ pill.setAttribute = () => {{}}; {words};
      const [inner, outer] = [pill, document.querySelector('#stick')].map((one) => one.getBoundingClientRect());
      return [inner.width > 0, inner.left - outer.left, inner.top - outer.top, outer.right - inner.right]; }}"""
    shown, *inside = page.locator("#connection").evaluate(measured)
    assert shown and min(inside) > 2, inside


SYLLABLES = """name => {
  const [text] = name.childNodes, start = text.data.indexOf("still"), part = document.createRange();
  return [[start, start + 4], [text.data.length - 4, text.data.length]].map(([from, to]) => {
    part.setStart(text, from);
    part.setEnd(text, to);
    return [part.toString(), [...part.getClientRects()].filter(({ width }) => width > 0).length];
  });
}"""


def test_the_name_of_a_partner_breaks_between_syllables(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    page = open_page(room["join_path"], room, **in_window(Window(553, 375, False, 0, "de-DE")))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.keyboard.press("KeyW")
    expect(page.locator("#seats [data-own] .seat-name")).to_contain_text("·")  # and the device, which takes its room
    assert page.locator("#seats .seat-name").last.evaluate(SYLLABLES) == [["stil", 1], ["teht", 1]]


def test_on_a_phone_nothing_stands_over_an_invitation(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("DistancePriority", red="link")
    page = open_page(room["join_path"], room, **in_window(Window(390, 664, True, 0)))
    expect(page.locator("#ready .share-link")).to_be_visible()
    open_page(room["watch_path"])
    expect(page.locator("#watchers")).to_have_text("1 person is watching.")
    expect(page.locator("#watchers")).to_be_hidden()


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_low_phone_sees_an_invitation_with_its_warning(server: Server, open_page: OpenPage, language: str) -> None:
    room = server.make_room("HandOff", red="link")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(Window(740, 360, True, 0, language)))
    for part in ("#ready .qr", "#ready .share-link", "#ready .button", "#ready .loopback"):
        expect(page.locator(part)).to_be_visible()
        assert_inside(page, part)
    assert page.locator("#ready").evaluate("(card) => card.scrollHeight <= card.clientHeight")


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_smallest_phone_on_its_side_has_the_button_of_an_invitation_in_one_line(
    server: Server, open_page: OpenPage, language: str
) -> None:
    room = server.make_room("HandOff", red="link")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(Window(568, 320, True, 0, language)))
    expect(page.locator("#ready .qr")).to_be_visible()
    assert page.locator("#ready .button").first.evaluate(LINES) == 1
    boxes = [assert_inside(page, part) for part in ("#ready .button", "#ready .share-link", "#ready", "#stop")]
    assert apart(boxes[2], boxes[3])


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_phone_on_its_side_shows_the_whole_arena_before_the_round(
    server: Server, open_page: OpenPage, language: str
) -> None:
    room = server.make_room("DistancePriority", red="idle")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(Window(844, 390, True, 0, language)))
    expect(page.locator("#ready .button")).to_be_visible()
    boxes = [assert_inside(page, part) for part in ("#arena", ".play-head", "#ready", ".play-seats", "#connection")]
    assert all(apart(one, other) for one, other in combinations(boxes, 2))
    assert page.locator("#ready").evaluate("(card) => card.scrollHeight <= card.clientHeight")


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_screen_of_a_study_is_wider_than_a_small_phone(open_page: OpenPage, language: str) -> None:
    study = FakeStudy.at(*study_fake.every_screen().values())
    person = study.people["token-of-person-1"]
    person.language = language
    page = open_page("/healthz", **SMALL)
    for name, step in study_fake.every_screen().items():
        person.steps = [step]
        study.open(page, f"?lang={language}") if name == "consent" else page.reload()
        expect(page.locator("#study-screen h1")).to_be_visible()
        assert_narrow(page, name)


def test_a_long_title_of_a_study_widens_no_screen(open_page: OpenPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_fake, "TITLE", "A short game with a partner whom you have never met before")
    page = open_page("/healthz", **SMALL)
    FakeStudy.at(study_fake.every_screen()["consent"]).open(page, "?lang=en")
    expect(page.locator("#study-part")).to_be_visible()
    assert_narrow(page, "consent")


WORD = "Rechtsschutzversicherungsgesellschaften" + "w" * 22


def long_words() -> dict[str, study_fake.Step]:
    """Screens in which whatever the author of a study writes is one long word."""
    likert, choice = PAPER.items[0].as_json(), DEMOGRAPHICS.items[0].as_json() | {"kind": "choice"}
    asked = [{**likert, "text": WORD, "ends": [WORD, WORD]}, {**choice, "options": ["no", WORD]}]
    written = [{"id": "own", "kind": "text", "label": "Own", "text": WORD}]
    consent, form = study_fake.consent(), study_fake.questions(PAPER)
    return {
        "consent": {**consent, "html": f"<p>{WORD}</p><ul><li>{WORD}</li></ul>", "boxes": [
            {"id": "adult", "text": WORD, "required": True}]},
        "questions": {**form, "items": asked},
        "text": {**form, "items": written},
        "round": study_fake.play(map_named=True, description=WORD),
    }  # fmt: skip


@pytest.mark.parametrize("screen", long_words())
def test_a_long_word_in_the_texts_of_a_study_widens_no_screen(open_page: OpenPage, screen: str) -> None:
    page = open_page("/healthz", **SMALL)
    FakeStudy.at(long_words()[screen]).open(page)
    expect(page.get_by_text(WORD).last).to_be_visible()
    assert_narrow(page, screen)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_experimenter_has_nothing_to_scroll_to_the_side(open_page: OpenPage, language: str) -> None:
    locale = {"en": "en-GB", "de": "de-DE"}[language]
    page = open_page("/healthz", script=UNLOCKED, locale=locale, **SMALL)
    FakeDashboard().open(page)
    assert_narrow(page, "experimenter")


DEJAVU = Path("/usr/share/fonts/truetype/dejavu")
ONLY_DEJAVU = """<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir>{fonts}</dir><cachedir>{cache}</cachedir></fontconfig>"""


WIDTH_OF_TEXT = """(font) => {
  const text = document.body.appendChild(document.createElement("span"));
  text.style.fontFamily = font;
  text.textContent = "Rückwärts fahren und greifen";
  const { width } = text.getBoundingClientRect();
  text.remove();
  return width;
}"""


@pytest.mark.skipif(not DEJAVU.is_dir(), reason="DejaVu is not installed")
def test_a_wide_font_alone_on_a_machine_is_set_as_wide_as_others(
    browser: Browser, server: Server, tmp_path: Path
) -> None:
    configuration = tmp_path / "fonts.conf"
    configuration.write_text(ONLY_DEJAVU.format(fonts=DEJAVU, cache=tmp_path / "cache"), encoding="utf-8")
    path, flags = str(find_chromium()), list(FLAGS)
    around: dict[str, str | float | bool] = {**os.environ, "FONTCONFIG_FILE": str(configuration)}
    alone = browser.browser_type.launch(executable_path=path, args=flags, env=around)
    try:
        with complaining_page(alone, server, "/?lang=de", **SMALL) as page:
            expect(page.locator(".map canvas").first).to_be_visible(timeout=30_000)
            widths = [page.evaluate(WIDTH_OF_TEXT, font) for font in ("var(--font)", "DejaVu Sans")]
            assert widths[0] < 0.9 * widths[1]
            assert_narrow(page, "the lobby in DejaVu")
    finally:
        alone.close()
