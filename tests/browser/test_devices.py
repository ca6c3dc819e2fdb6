"""Keyboard, gamepad and touch at the game page, for one person and for two at one screen."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import CDPSession, Page, expect

from tests.browser.pages import overflow
from tests.browser.support import PHONE, Server, robot, seat_tokens_script, start, wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
INPUT = b"\x03"  # the first byte of an input frame

PAD_STUB = """
window.__pad = { plugged: true, axes: [0, 0, 0, 0], down: [] };
navigator.getGamepads = () => [window.__pad.plugged ? {
  index: 0, id: "Stub pad", connected: true, mapping: "standard", axes: window.__pad.axes,
  buttons: Array.from({ length: 17 }, (_, i) => ({
    pressed: window.__pad.down.includes(i), touched: false, value: Number(window.__pad.down.includes(i)),
  })),
} : null];
"""


def set_pad(page: Page, x: float = 0.0, y: float = 0.0, *down: int, plugged: bool = True) -> None:
    page.evaluate(
        "([x, y, down, plugged]) => Object.assign(window.__pad, { axes: [x, y, 0, 0], down, plugged })",
        [x, y, list(down), plugged],
    )


def test_a_gamepad_gets_ready_drives_and_lets_go_when_unplugged(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room, script=PAD_STUB)
    wait_for(page, "game.phase === 'lobby'")
    expect(page.get_by_role("button", name="I am ready")).to_be_visible()
    set_pad(page, 0, 0, 0)
    wait_for(page, "game.phase === 'playing'")
    set_pad(page, 0, -1)
    wait_for(page, "game.entities().robots[0].y > -0.8")
    expect(page.locator("#seats")).to_contain_text("You · gamepad")
    expect(page.locator("#controls")).to_contain_text("left stick")
    set_pad(page, 0, 1, 6)  # the trigger: back to where it came from without turning round
    wait_for(page, "game.entities().robots[0].y < -0.85")
    assert abs(robot(page, 0)["angle"]) < 0.3
    set_pad(page, plugged=False)
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay")).to_contain_text(
        "Your gamepad is no longer connected. Plug it in again, or continue with the"
    )
    expect(page.locator("#overlay")).not_to_contain_text("You paused")
    set_pad(page)
    expect(page.locator("#overlay")).to_contain_text("Your gamepad is connected again.")
    set_pad(page, plugged=False)
    expect(page.locator("#seats")).to_contain_text("You · keyboard")
    expect(page.locator("#overlay p", has_text="Press Space or Enter to continue.")).to_be_visible()
    page.keyboard.press("Space")
    wait_for(page, "game.phase === 'playing'")
    stands_still(page, 0)


@pytest.mark.parametrize("language", ["en", "de"])
def test_two_at_one_phone_are_told_that_fingers_drive_blue_alone(
    server: Server, open_page: OpenPage, pictures: Path, language: str
) -> None:
    phone = {"viewport": {"width": 390, "height": 664}, "has_touch": True, "is_mobile": True}
    page = open_page("/", locale=language, **phone)
    expect(page.locator("#play")).to_be_enabled()
    page.locator("#seat-1").scroll_into_view_if_needed()
    page.locator("#seat-1").select_option("here")
    expect(page.locator("#seats-note")).to_contain_text("↑ ← ↓ →")
    expect(page.locator("#seats-note")).not_to_contain_text("W A S D")
    page.locator("#play").tap()
    expect(page.locator("#ready .button-small")).to_have_count(2)
    expect(page.locator("#ready")).to_contain_text("↑ ← ↓ →")
    assert overflow(page) == 0
    page.screenshot(path=pictures / f"phone-two-{language}.png")


def test_touch_drives_with_one_thumb_and_grabs_with_the_other(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room, viewport=PHONE, has_touch=True, is_mobile=True, device_scale_factor=2)
    start(page, tap=True)
    touch = page.context.new_cdp_session(page)
    stick, grab = centre(page, "#stick"), centre(page, "#touch-grab")
    aim = {"x": stick["x"] + 22, "y": stick["y"] - 44}  # at the star
    send(touch, "touchStart", {"id": 1, **stick})
    send(touch, "touchMove", {"id": 1, **aim})
    wait_for(page, "game.entities().robots[0].y > -0.96")
    page.wait_for_timeout(500)
    for _ in range(6):
        send(touch, "touchStart", {"id": 1, **aim}, {"id": 2, **grab})
        send(touch, "touchEnd", {"id": 1, **aim})
        page.wait_for_timeout(400)
        if robot(page, 0)["held"] == 0:
            break
    assert robot(page, 0)["held"] == 0
    expect(page.locator("#seats")).to_contain_text("carrying a star")
    page.screenshot(path=pictures / "phone.png")
    send(touch, "touchEnd")
    stands_still(page, 0)
    send(touch, "touchStart", {"id": 3, **grab}, {"id": 4, **grab, "x": grab["x"] + 20})  # both thumbs at once
    wait_for(page, "game.entities().robots[0].held === -1")
    page.wait_for_timeout(400)
    assert robot(page, 0)["held"] == -1, "two fingers are one press"
    send(touch, "touchEnd")
    send(touch, "touchStart", {"id": 5, **grab})
    wait_for(page, "game.entities().robots[0].held === 0")
    send(touch, "touchEnd")
    send(touch, "touchStart", {"id": 6, **stick, "y": PHONE["height"] - 12})  # the ring would reach below the window
    expect(page.locator("#knob")).to_have_attribute("data-held", "true")
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    send(touch, "touchEnd")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator("#arena").bounding_box()["width"] > 340  # type: ignore[index]
    assert grab["y"] < PHONE["height"], "the grab button is on the first screen"


def test_two_people_at_one_screen_have_their_own_keys(server: Server, open_page: OpenPage) -> None:
    room = server.practice(red="here")
    page = open_page(room["join_path"], room)
    wait_for(page, "game.phase === 'lobby' && game.seats.length === 2")
    expect(page.locator("#controls")).to_contain_text("W A S D")
    page.keyboard.press("Space")
    expect(page.locator("#ready .pill-ok")).to_have_count(1)
    page.keyboard.press("Enter")
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.down("KeyW")
    page.keyboard.down("ArrowLeft")
    wait_for(page, "game.entities().robots[0].y > -0.8 && game.entities().robots[1].x < 0.4")
    assert abs(robot(page, 0)["x"] + 0.6) < 0.1
    page.keyboard.up("KeyW")
    page.keyboard.up("ArrowLeft")


def test_a_window_that_loses_the_focus_lets_go_of_the_keys(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    page.keyboard.down("KeyW")
    wait_for(page, "game.entities().robots[0].y > -0.9")
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    stands_still(page, 0)


def test_a_page_tells_whether_it_is_hidden_after_each_welcome_and_change(server: Server, open_page: OpenPage) -> None:
    page = open_page("/static/icon.svg")
    told: list[bool] = []

    def hear(sent: str | bytes) -> None:
        if isinstance(sent, str) and json.loads(sent)["type"] == "focus":
            told.append(json.loads(sent)["visible"])

    page.on("websocket", lambda line: line.on("framesent", hear))
    room = server.practice()
    page.evaluate(seat_tokens_script(room))
    page.goto(room["join_path"])
    page.get_by_role("button", name="I am ready").wait_for()
    page.evaluate("['blur', 'focus'].forEach((name) => window.dispatchEvent(new Event(name)))")  # not hidden by that
    for hidden in (True, False):
        page.evaluate(
            """(hidden) => {
                 Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
                 document.dispatchEvent(new Event("visibilitychange"));
               }""",
            hidden,
        )
    deadline = time.monotonic() + 10
    while len(told) < 3 and time.monotonic() < deadline:
        page.wait_for_timeout(50)
    assert told == [True, False, True]


def test_the_arrow_of_the_own_stick_is_there_before_the_server_answers(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    page.evaluate(
        """() => addEventListener("keydown", () => {
             const before = window.__movingout.frames;
             requestAnimationFrame(() => requestAnimationFrame(() => {
               window.__cue = { y: window.__movingout.intents[0].y, frames: window.__movingout.frames - before };
             }));
           }, { once: true })"""
    )
    page.keyboard.down("KeyW")
    page.wait_for_function("() => window.__cue")
    assert page.evaluate("window.__cue.y") == 1
    assert page.evaluate("window.__cue.frames") <= 2
    page.keyboard.up("KeyW")


def test_a_key_of_ones_own_choice_is_kept_in_the_browser(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    page.get_by_role("button", name="Change…").click()
    wait_for(page, "game.phase === 'paused'")
    page.get_by_role("button", name="grab: Space").click()
    page.keyboard.press("KeyQ")
    page.get_by_role("button", name="Done").click()
    expect(page.locator("#controls kbd", has_text="Q").first).to_be_visible()
    expect(page.locator("#overlay p", has_text="Press Q or Enter to continue")).to_be_visible()
    expect(page.get_by_role("button", name="Continue")).to_be_focused()
    page.keyboard.press("Space")  # no grab key any more, but it presses the button that has the focus
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Escape")
    wait_for(page, "game.phase === 'paused'")
    page.reload()
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay p", has_text="Press Q or Enter to continue")).to_be_visible()
    page.keyboard.press("KeyQ")
    wait_for(page, "game.phase === 'playing'")


def test_a_key_that_is_tried_in_the_settings_counts_for_nothing_else(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    page.get_by_role("button", name="Change…").click()
    page.get_by_role("button", name="grab: Space").click()
    for _ in range(2):
        page.keyboard.press("KeyF")
    page.get_by_role("button", name="Done").click()
    page.wait_for_timeout(300)
    assert page.evaluate("window.__movingout.phase") == "lobby", "nobody has said that they are ready"


def test_in_the_settings_the_keyboard_stays_where_something_was_changed(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    page.get_by_role("button", name="Change…").click()
    page.get_by_role("button", name="grab: Space").press("Enter")
    expect(page.get_by_role("button", name="press a key")).to_be_focused()  # what a screen reader says of it
    page.keyboard.press("KeyQ")
    expect(page.get_by_role("button", name="grab: Q")).to_be_focused()
    for name in ("grab: Q", "left: A"):
        page.get_by_role("button", name=name).click()
    expect(page.get_by_role("button", name="press a key")).to_have_count(1)  # who changes their mind reads one request
    page.keyboard.press("Escape")
    page.get_by_label("Stick dead zone").select_option("0.15")
    expect(page.get_by_label("Stick dead zone")).to_be_focused()
    page.get_by_role("button", name="Reset to defaults").press("Enter")
    expect(page.get_by_role("button", name="Reset to defaults")).to_be_focused()


def test_while_the_settings_are_open_the_page_goes_on_to_say_what_has_arrived(
    server: Server, open_page: OpenPage
) -> None:
    room = server.practice()
    page = open_page("/healthz")
    page.context.add_init_script(seat_tokens_script(room))
    inputs: list[bool] = []
    page.on("websocket", lambda line: line.on("framesent", lambda sent: inputs.append(sent[:1] == INPUT)))
    page.goto(room["join_path"])
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'countdown'")
    page.get_by_role("button", name="Change…").click()
    expect(page.locator("#settings")).to_be_visible()
    inputs.clear()
    page.wait_for_timeout(1000)
    assert sum(inputs) >= 10
    wait_for(page, "game.phase === 'paused'")  # and nobody plays on behind the dialog


def test_a_key_a_switch_or_a_voice_presses_the_buttons_for_fingers(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room, viewport=PHONE, has_touch=True, is_mobile=True)
    start(page, tap=True)
    page.locator("#touch-grab").press("Space")
    wait_for(page, "game.cues.missed === 1")  # nothing is in reach
    page.locator("#touch-backward").press("Enter")
    expect(page.locator("#touch-backward")).to_have_attribute("aria-pressed", "true")
    page.locator("#touch-backward").press("Enter")
    expect(page.locator("#touch-backward")).to_have_attribute("aria-pressed", "false")


def test_a_key_that_is_in_use_is_exchanged_only_when_asked(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    page.get_by_role("button", name="Change…").click()
    page.get_by_role("button", name="grab: Space").click()
    page.keyboard.press("KeyW")
    expect(page.get_by_role("alert")).to_contain_text("W is already used for: up (First keys). Swap the two?")
    page.get_by_role("button", name="Leave as it is").click()
    expect(page.get_by_role("button", name="grab: Space")).to_be_visible()
    page.get_by_role("button", name="grab: Space").click()
    page.keyboard.press("KeyP")
    expect(page.locator("#settings")).to_contain_text("P pauses the game. Please choose another key.")
    page.get_by_role("button", name="grab: Space").click()
    page.keyboard.press("ControlLeft")
    expect(page.locator("#settings")).to_contain_text("Left Ctrl is for shortcuts. Please choose another key.")
    page.get_by_role("button", name="grab: Space").click()
    page.keyboard.press("KeyW")
    page.get_by_role("button", name="Swap them").click()
    expect(page.get_by_role("button", name="grab: W")).to_be_visible()
    expect(page.get_by_role("button", name="up: Space")).to_be_visible()


@pytest.mark.parametrize("by", ["mouse", "keyboard"])
def test_whoever_pauses_by_the_button_continues_with_the_key_that_is_named(
    server: Server, open_page: OpenPage, by: str
) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    start(page)
    button = page.get_by_role("button", name="Pause or stop…")
    button.click() if by == "mouse" else button.press("Enter")
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay p", has_text="Press Space or Enter to continue.")).to_be_visible()
    page.keyboard.press("Space")  # not once more for the button
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Escape")
    wait_for(page, "game.phase === 'paused'")
    button.click()
    expect(page.get_by_role("button", name="No, go back")).to_be_focused()


# Nothing lies over the element, nor is it scrolled or cut away.
TOPMOST = """element => {
    const { left, top, width, height } = element.getBoundingClientRect();
    return [0.1, 0.9].every(part => element.contains(document.elementFromPoint(left + width / 2, top + part * height)));
}"""


@pytest.mark.parametrize(("width", "height"), [(375, 553), pytest.param(320, 568, marks=pytest.mark.slow)])
def test_with_a_gamepad_on_a_small_screen_a_pause_shows_both_its_buttons(
    server: Server, open_page: OpenPage, width: int, height: int
) -> None:
    room = server.practice()
    page = open_page(
        room["join_path"], room, script=PAD_STUB, viewport={"width": width, "height": height}, locale="de-DE"
    )
    page.get_by_role("button", name="Ich bin bereit").click()
    wait_for(page, "game.phase === 'playing'")
    set_pad(page, 0.5)
    expect(page.get_by_text("linker Stick")).to_be_visible()
    set_pad(page, 0, 0, 9)
    wait_for(page, "game.phase === 'paused'")
    for name in ("Weiter", "Spiel beenden"):
        button = page.locator("#overlay").get_by_role("button", name=name)
        expect(button).to_be_visible()
        assert button.evaluate(TOPMOST), name
    assert page.locator(".panel").evaluate("panel => panel.scrollHeight <= panel.clientHeight"), "words are cut off"


def test_a_press_right_after_the_page_opened_counts(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    expect(page.get_by_text("Press Space or Enter when you are ready.")).to_be_visible()
    page.keyboard.press("Space")
    wait_for(page, "game.phase === 'playing'")


def stands_still(page: Page, seat: int) -> None:
    """Within a second the robot stops, and stays there."""
    page.wait_for_function(
        """async (seat) => {
             const here = () => window.__movingout.entities().robots[seat];
             const before = here();
             await new Promise((resolve) => setTimeout(resolve, 400));
             return Math.hypot(here().x - before.x, here().y - before.y) < 0.001;
           }""",
        arg=seat,
        timeout=8000,
    )


def centre(page: Page, selector: str) -> dict[str, float]:
    box = page.locator(selector).bounding_box()
    assert box is not None
    return {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}


def send(touch: CDPSession, kind: str, *points: dict[str, Any]) -> None:
    touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})
