"""The game page in real windows: a round never scrolls, all that matters is on screen, nothing moves at its start."""

import json
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from playwright.sync_api import CDPSession, Page, expect

from tests.browser.pages import overflow
from tests.browser.support import Server, robot, start, wait_for
from tests.browser.test_decision_trace import TRACE, weigh

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
Box = tuple[float, float, float, float]  # left, top, right, bottom in CSS pixels

TARGET = 44  # WCAG 2.5.5
PARTS = ["#time", "#done", "#arena", "#seats .seat:first-child", "#seats .seat:last-child", "#stop"]
THUMBS = ["#stick", "#touch-grab", "#touch-backward", "#touch-ping"]
SHIFTS = """() => {
  window.__shift = 0;
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) window.__shift += entry.value;
  }).observe({ type: "layout-shift" });
}"""


class Window(NamedTuple):
    """A window, what drives there, and how large the arena must at least be."""

    width: int
    height: int
    touch: bool
    arena: int
    language: str = "en-GB"
    dark: bool = False

    def __str__(self) -> str:
        return f"{self.width}x{self.height}{'-touch' if self.touch else ''}"


WINDOWS = [
    Window(390, 664, True, 370),
    Window(375, 553, True, 330, "de-DE"),
    Window(320, 568, True, 300, "de-DE"),
    Window(568, 320, True, 260, "de-DE"),
    Window(280, 653, True, 260),
    Window(360, 640, True, 340, "de-DE", dark=True),
    Window(412, 732, True, 390),
    Window(667, 375, True, 350, "de-DE"),
    Window(844, 390, True, 370),
    Window(768, 1024, True, 750),
    Window(1024, 768, True, 700, "de-DE"),
    Window(375, 553, False, 280, "de-DE"),
    Window(720, 450, False, 430, "de-DE"),  # 1440 by 900 at a zoom of 200 %
    Window(1024, 768, False, 730, "de-DE"),
    Window(960, 540, False, 500, "de-DE", dark=True),
    Window(1280, 800, False, 750),
    Window(1440, 900, False, 850, "de-DE"),
]


def in_window(window: Window) -> dict[str, Any]:
    """The options of a browser context for it."""
    return {
        "viewport": {"width": window.width, "height": window.height},
        "has_touch": window.touch,
        "is_mobile": window.touch,
        "locale": window.language,
        "color_scheme": "dark" if window.dark else "light",
    }


def box(page: Page, selector: str) -> Box:
    found = page.locator(selector).bounding_box()
    assert found is not None, f"{selector} is not shown"
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def assert_inside(page: Page, selector: str) -> Box:
    """The part is shown, wholly in the window, and no part of its text is cut off."""
    left, top, right, bottom = found = box(page, selector)
    size = page.viewport_size
    assert size is not None
    assert left >= 0, selector
    assert top >= 0, selector
    assert right <= size["width"], selector
    assert bottom <= size["height"], selector
    cut = page.locator(selector).evaluate("part => [part, ...part.querySelectorAll('*')].filter(cutOff).length")
    assert cut == 0, f"the text of {selector} is cut off"
    return found


# What is in an input scrolls: how long the link to a room is depends on the letters of its code.
CUT_OFF = """
window.cutOff = (part) => !part.closest("svg") && !part.matches("input") && part.textContent.trim() !== ""
  && getComputedStyle(part).position !== "absolute"
  && part.scrollWidth > part.clientWidth + 1 && part.clientWidth > 1 && getComputedStyle(part).display !== "inline";
"""


def apart(one: Box, other: Box) -> bool:
    return one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


def scrolls(page: Page) -> bool:
    higher: bool = page.evaluate("document.documentElement.scrollHeight > innerHeight")
    return higher or overflow(page) > 0


def begin(page: Page, touch: bool) -> None:
    """Ready, by the button that is on the screen without scrolling."""
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    button = page.locator("#ready button.button-primary")
    expect(button).to_be_visible()
    assert not scrolls(page)
    left, top, right, bottom = assert_inside(page, "#ready button.button-primary")
    assert bottom - top >= TARGET
    x, y = (left + right) / 2, (top + bottom) / 2
    if touch:
        page.touchscreen.tap(x, y)
    else:
        page.mouse.click(x, y)
    wait_for(page, "game.phase === 'playing'")


@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_a_round_fits_the_window_and_nothing_moves_when_it_starts(
    server: Server, open_page: OpenPage, pictures: Path, window: Window
) -> None:
    room = server.make_room("AdaptiveAssist", red="scripted")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.screenshot(path=pictures / f"layout-{window}-lobby.png")
    before = [box(page, part) for part in PARTS]
    for pill in page.locator(".play-connection .row:visible").all():
        shown = pill.bounding_box()
        assert shown is not None
        edges = (shown["x"], shown["y"], shown["x"] + shown["width"], shown["y"] + shown["height"])
        assert apart(edges, box(page, "#ready")), "the connection looks out from under the question"
    page.evaluate(SHIFTS)
    begin(page, window.touch)
    wait_for(page, "game.tick > 1")  # every part has been written since
    assert not scrolls(page)
    beside = ["#controls"] if window.width < window.height else ["#controls", "#connection"]
    parts = ["#mute", *PARTS, *(THUMBS if window.touch else beside)]
    boxes = {part: assert_inside(page, part) for part in parts}
    assert boxes["#arena"][2] - boxes["#arena"][0] >= window.arena
    for index, part in enumerate(parts):
        assert all(apart(boxes[part], boxes[other]) for other in parts[:index]), f"{part} covers something"
    if not window.touch:
        assert page.evaluate("(({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight)(controls)"), "cut off"
    for part in ["#stop", *(THUMBS if window.touch else [])]:
        left, top, right, bottom = boxes[part]
        assert min(right - left, bottom - top) >= TARGET, part
    assert [boxes[part][:2] for part in ("#arena", "#stop")] == [
        before[PARTS.index(part)][:2] for part in ("#arena", "#stop")
    ]
    assert page.evaluate("window.__shift") < 0.02, "a fifth of what Web Vitals call good"
    page.screenshot(path=pictures / f"layout-{window}-play.png")
    pause = page.locator("#stop")
    pause.tap() if window.touch else pause.click()
    wait_for(page, "game.phase === 'paused'")
    assert_inside(page, "#overlay .panel")
    assert not scrolls(page)
    page.screenshot(path=pictures / f"layout-{window}-pause.png")


@pytest.mark.parametrize("blue", ["here", "bass@any"])
@pytest.mark.parametrize(
    "window",
    [
        Window(320, 568, True, 300, "de-DE"),
        Window(360, 640, True, 340, "de-DE"),
        Window(640, 360, False, 340, "de-DE"),  # 1280 by 720 at a zoom of 200 %
    ],
    ids=str,
)
def test_the_name_of_the_partner_whom_the_lobby_proposes_covers_nothing(
    server: Server, open_page: OpenPage, pictures: Path, window: Window, blue: str
) -> None:
    room = server.make_room("AdaptiveAssist", blue=blue, red="bass@any" if blue == "here" else "here")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    if window.touch:
        page.touchscreen.tap(10, 10)
    expect(page.locator("#seats [data-own] .seat-name")).to_contain_text("·")  # and the device
    page.screenshot(path=pictures / f"layout-{window}-name-{blue}.png")
    for seat in page.locator("#seats .seat-name").all():
        shown = seat.bounding_box()
        assert shown is not None
        name = (shown["x"], shown["y"], shown["x"] + shown["width"], shown["y"] + shown["height"])
        assert all(apart(name, box(page, part)) for part in ("#arena", "#mute", "#stop"))
    if not window.touch:
        assert_inside(page, "#controls button")


@pytest.mark.parametrize(
    "window", [Window(640, 360, True, 340, "de-DE"), Window(667, 375, True, 350, "de-DE")], ids=str
)
def test_three_lines_about_a_player_stand_above_the_stick(server: Server, open_page: OpenPage, window: Window) -> None:
    room = server.make_room("DistancePriority", red="idle")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    begin(page, window.touch)
    wait_for(page, "game.tick > 1")
    below = page.evaluate(  # the longest that a partner may do, before the page writes what this one does
        """async () => {
          const { say } = await import("/static/text/catalogue.js");
          const item = say("shape.circle");
          const [words] = document.querySelectorAll("#seats .seat:last-child .seat-words");
          words.textContent = say("play.state.slow", { item });
          return document.querySelector("#seats").getBoundingClientRect().bottom;
        }"""
    )
    assert below <= box(page, "#stick")[1]


@pytest.mark.parametrize(
    "window",
    [Window(900, 640, False, 600, "de-DE"), Window(375, 553, True, 350), Window(844, 390, True, 360)],
    ids=str,
)
def test_whoever_watches_sees_the_whole_arena(
    server: Server, open_page: OpenPage, pictures: Path, window: Window
) -> None:
    room = server.make_room("DistancePriority", red="scripted")
    player = open_page(room["join_path"], room)
    page = open_page(room["watch_path"], script=CUT_OFF, **in_window(window))
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    watched = [".play-head", *PARTS, "#mute"]
    before = _apart_and_inside(page, watched, window)
    player.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'countdown'")
    left, _, right, _ = box(page, ".play-head")
    assert right - left > 1, "the heading stays while they count down"
    wait_for(page, "game.phase === 'playing'")
    after = _apart_and_inside(page, watched, window)
    assert before["#arena"] == after["#arena"]
    page.screenshot(path=pictures / f"layout-{window}-watch.png")


@pytest.mark.parametrize("window", [Window(375, 553, True, 200, "de-DE"), Window(390, 664, False, 250)], ids=str)
def test_on_a_phone_what_agents_consider_has_a_place_of_its_own(
    server: Server, open_page: OpenPage, window: Window
) -> None:
    room = server.make_room("HandOff", red="idle")
    page = open_page("/healthz", script=CUT_OFF, **in_window(window))
    weigh(page, TRACE)
    page.goto(room["watch_path"])
    switch = "#decisions button"
    page.locator(switch).wait_for()
    before = _apart_and_inside(page, [".play-head", switch, *PARTS, "#mute"], window)
    page.locator(switch).click()
    start(open_page(room["join_path"], room))
    expect(page.locator("#decisions").get_by_role("listitem")).to_have_count(4)
    parts = [".play-head", switch, *PARTS, "#mute", ".decision-lists", "#watchers"]
    after = _apart_and_inside(page, parts, window)
    assert after[switch][1:3] == before[switch][1:3], "it stays under the finger"


def _apart_and_inside(page: Page, parts: list[str], window: Window) -> dict[str, Box]:
    boxes = {part: assert_inside(page, part) for part in parts}
    for index, part in enumerate(parts):
        assert all(apart(boxes[part], boxes[other]) for other in parts[:index]), f"{part} covers something"
    assert boxes["#arena"][2] - boxes["#arena"][0] >= window.arena
    assert not scrolls(page)
    return boxes


PHONE_LOW = Window(375, 553, True, 330)


@pytest.mark.parametrize(
    ("window", "tutorial"),
    [
        (PHONE_LOW, False),
        (Window(667, 375, True, 350), False),
        (PHONE_LOW, True),
        (Window(390, 664, True, 340, "de-DE"), True),
        (Window(360, 640, True, 320, "de-DE"), True),
    ],
    ids=str,
)
def test_the_practice_of_a_study_fits_a_phone(
    server: Server, open_page: OpenPage, pictures: Path, window: Window, tutorial: bool
) -> None:
    room = server.post("/api/rooms", {"tutorial": True}) if tutorial else server.practice()
    mark = {"room": room["room"], "key": "practice", "name": "Practice", "practice": True, "tutorial": tutorial}
    mark["sounds"] = tutorial
    keep = f"sessionStorage.setItem('movingout-study-round', {json.dumps(json.dumps(mark))})"
    script = f"{CUT_OFF} if (location.protocol !== 'about:') {keep};"
    page = open_page(room["join_path"], room, script=script, **in_window(window))
    wait_for(page, "game.phase === 'playing'")  # in a study it was asked before whether one is ready
    told = [".tutorial-words", ".play-tutorial .row", "#arena", "#stop", "#mute"] if tutorial else PARTS
    parts = [*told, *THUMBS[: 3 if tutorial else 4], ".play-enough"]  # a tutorial has no pings
    boxes = [assert_inside(page, part) for part in parts]
    for index, one in enumerate(boxes):
        assert all(apart(one, other) for other in boxes[:index]), parts[index]
    assert not scrolls(page)
    page.screenshot(path=pictures / f"layout-{window}-practice{'-tutorial' * tutorial}.png")


def test_on_a_phone_with_a_notch_everything_stays_clear_of_it(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    window = Window(390, 844, True, 370)
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    page.context.new_cdp_session(page).send(
        "Emulation.setSafeAreaInsetsOverride", {"insets": {"top": 47, "bottom": 34, "left": 0, "right": 0}}
    )
    begin(page, touch=True)
    assert box(page, "#stop")[1] >= 47
    assert box(page, "#touch-grab")[3] <= window.height - 34
    assert not scrolls(page)


# ---- played by touch alone --------------------------------------------------------------------------------------


class Thumbs:
    """Two thumbs: one on the stick, one for Grab, as the touch events of a real screen."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._session: CDPSession = page.context.new_cdp_session(page)
        left, top, right, bottom = box(page, "#stick")
        self._centre = (left + right) / 2, (top + bottom) / 2
        self._reach = (bottom - top) * 0.42

    def _send(self, kind: str, *points: tuple[float, float]) -> None:
        touches = [{"id": number, "x": x, "y": y} for number, (x, y) in enumerate(points)]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

    @contextmanager
    def on_the_stick(self) -> Iterator[None]:
        self._send("touchStart", self._centre)
        yield
        self._send("touchEnd")

    def push(self, right: float, up: float) -> None:
        """As far as the stick goes, in this direction."""
        x, y = self._centre
        length = math.hypot(right, up) or 1.0
        self._send("touchMove", (x + self._reach * right / length, y - self._reach * up / length))

    def grab(self) -> None:
        left, top, right, bottom = box(self._page, "#touch-grab")
        self._page.touchscreen.tap((left + right) / 2, (top + bottom) / 2)

    def drive_to(self, seat: int, x: float, y: float, near: float) -> None:
        for _ in range(200):
            here = robot(self._page, seat)
            if math.hypot(x - here["x"], y - here["y"]) < near:
                return
            self.push(x - here["x"], y - here["y"])
            self._page.wait_for_timeout(50)
        raise AssertionError(f"the robot does not get to {x}, {y}")


def test_a_small_phone_brings_an_item_home_by_touch_alone(server: Server, open_page: OpenPage, pictures: Path) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(PHONE_LOW))
    begin(page, touch=True)
    thumbs = Thumbs(page)
    star = page.evaluate("window.__movingout.entities().items[0]")
    for _ in range(6):
        with thumbs.on_the_stick():
            thumbs.drive_to(0, star["x"], star["y"], 0.2)
        thumbs.grab()
        page.wait_for_timeout(400)
        if robot(page, 0)["held"] == 0:
            break
    assert robot(page, 0)["held"] == 0
    expect(page.locator("#seats")).to_contain_text("carrying a star")
    with thumbs.on_the_stick():
        thumbs.drive_to(0, -0.9, 0.85, 0.1)
    thumbs.grab()
    page.screenshot(path=pictures / "layout-375x553-home.png")
    wait_for(page, "game.entities().items[0].delivered")
    expect(page.locator("#done")).to_have_text("1 / 3")
    assert page.evaluate("scrollY") == 0


@pytest.mark.parametrize("language", ["en-GB", "de-DE"])
def test_the_lowest_windows_show_the_button_to_be_ready(server: Server, open_page: OpenPage, language: str) -> None:
    window = Window(568, 264, False, 0, language)
    room = server.make_room("AdaptiveAssist", red="idle")
    page = open_page(room["join_path"], room, script=CUT_OFF, **in_window(window))
    begin(page, window.touch)
