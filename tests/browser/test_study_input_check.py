"""The screen on which controls are tried and the connection is measured, on every device."""

import pytest
from playwright.sync_api import Browser, Route, expect

from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.pages import complaining_page, heading, press, violations
from tests.browser.study_fake import FakeStudy
from tests.browser.support import PHONE, Server
from tests.browser.test_devices import PAD_STUB, set_pad

pytestmark = pytest.mark.slow


def test_the_controls_are_tried_and_the_connection_is_measured(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check(), fake.code())
    page = open_page("/healthz")
    study.open(page)
    heading(page, "Try your controls")
    expect(page.locator(".check-connection .pill")).to_contain_text("ms")
    on = page.get_by_role("button", name="Continue", exact=True)
    expect(on).to_be_disabled()
    expect(page.get_by_text("Please also try: up, left, down, right, Grab, and Drive backward.")).to_have_count(1)
    page.keyboard.down("KeyW")
    expect(page.locator("[data-lit]")).to_have_text("up")
    page.keyboard.up("KeyW")
    press(page, "ArrowLeft", "KeyS", "KeyD", "Space")
    expect(page.get_by_text("Please also try: Drive backward.")).to_be_visible()
    press(page, "ShiftLeft")
    expect(page.get_by_text("Everything works.")).to_be_visible()
    expect(page.get_by_role("alert").filter(has_text="Please")).to_have_count(0)
    on.press("Enter")
    heading(page, "Thank you")
    (sent,) = study.sent("/next")
    assert sent["device"] == "keyboard" and 0 < sent["rtt_ms"] < 2000 and sent["untried"] == []


def test_what_was_tried_stays_when_the_language_is_changed(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    FakeStudy.at(fake.input_check()).open(page)
    heading(page, "Try your controls")
    press(page, "KeyW", "KeyA", "KeyD")
    expect(page.get_by_text("Please also try: down, Grab, and Drive backward.")).to_be_visible()
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_text("Bitte probieren Sie auch: unten, Greifen und Rückwärts fahren.")).to_be_visible()


def test_in_forced_colours_the_stick_can_be_seen(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check(), fake.code())
    page = open_page("/healthz", forced_colors="active")
    study.open(page)
    dot = page.locator(".check-dot").first
    grounds = [one.evaluate("one => getComputedStyle(one).backgroundColor") for one in (dot, page.locator("body"))]
    assert grounds[0] != grounds[1]


@pytest.mark.parametrize("key", ["Space", "Enter"])
def test_a_button_with_the_focus_does_not_take_the_first_grab(open_page: OpenPage, key: str) -> None:
    study = FakeStudy.at(fake.input_check(), fake.code())
    page = open_page("/healthz")
    study.open(page)
    expect(page.locator(".check-connection .pill")).to_contain_text("ms")
    press(page, "KeyW", "KeyA", "KeyS", "KeyD", "ShiftLeft")
    again = page.get_by_role("button", name="Measure again")
    again.click()
    expect(again).to_be_focused()
    expect(page.get_by_text("Please also try: Grab.")).to_be_visible()
    press(page, key)
    expect(page.get_by_text("Everything works.")).to_be_visible()
    expect(again).to_be_focused()
    expect(page.get_by_text("Does a control not work?")).to_be_hidden()


def test_whose_device_lacks_a_control_goes_on_and_the_server_is_told(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check(), fake.code())
    page = open_page("/healthz")
    study.open(page)
    heading(page, "Try your controls")
    press(page, "KeyW", "KeyA", "KeyS", "Space", "ShiftLeft")
    expect(page.get_by_text("Please also try: right.")).to_be_visible()
    page.get_by_role("button", name="Does a control not work?").press("Enter")
    assert violations(page) == []
    page.get_by_role("button", name="Continue without trying it").press("Enter")
    heading(page, "Thank you")
    assert study.sent("/next")[0]["untried"] == ["right"]


def test_going_on_while_the_connection_is_still_measured_waits_for_it(open_page: OpenPage) -> None:
    study, held = FakeStudy.at(fake.input_check(), fake.code()), list[Route]()
    page = open_page("/healthz")
    page.route("**/healthz", lambda route: held.append(route))
    study.open(page)
    heading(page, "Try your controls")
    press(page, "KeyW", "KeyA", "KeyS", "KeyD", "Space")
    expect(page.get_by_text("Please also try: Drive backward.")).to_be_visible()
    press(page, "ShiftLeft")
    expect(page.get_by_text("Everything works.")).to_be_visible()
    on = page.get_by_role("button", name="Continue", exact=True)
    on.click()
    expect(on).to_have_attribute("aria-disabled", "true")
    expect(page.locator(".check-connection .pill")).to_have_text("measuring…")
    page.unroute("**/healthz")
    for route in held:
        route.continue_()
    heading(page, "Thank you")
    (sent,) = study.sent("/next")
    assert 0 < sent["rtt_ms"] < 2000


def test_where_a_gamepad_is_needed_it_is_tried_and_keys_do_not_count(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check(gamepad_required=True), fake.code())
    page = open_page("/healthz", script=PAD_STUB)
    study.open(page)
    expect(page.get_by_text("This study is played with a gamepad.")).to_be_visible()
    press(page, "KeyW", "KeyA", "KeyS", "KeyD", "Space")
    expect(page.get_by_text("Please also try: up, left, down, right, Grab, and Drive backward.")).to_be_visible()
    for x, y in ((0, -1), (0, 1), (-1, 0), (1, 0)):
        set_pad(page, x, y)
        expect(page.locator(".check-arrow[data-lit]")).to_have_count(1)
        set_pad(page)
        expect(page.locator(".check-arrow[data-lit]")).to_have_count(0)
    set_pad(page, 0, 0, 0)
    expect(page.get_by_text("Please also try: Drive backward.")).to_be_visible()
    set_pad(page, 0, 0, 6)
    expect(page.get_by_text("Everything works.")).to_be_visible()
    expect(page.locator(".check-panel")).to_contain_text("Move with the left stick, grab with A")
    page.get_by_role("button", name="Continue").click()
    heading(page, "Thank you")
    assert study.sent("/next")[0]["device"] == "gamepad"


def test_a_finger_can_try_the_controls_on_a_phone(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.input_check())
    page = open_page("/healthz", viewport=PHONE, has_touch=True, is_mobile=True)
    study.open(page)
    box = page.locator(".check-stick").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for dx, dy in ((0, -50), (-50, 0), (0, 50), (50, 0)):
        page.mouse.move(x + dx, y + dy)
        expect(page.locator(".check-arrow[data-lit]")).to_have_count(1)
    page.mouse.up()
    page.get_by_role("button", name="Grab").tap()
    page.get_by_role("button", name="Drive backward").tap()
    expect(page.get_by_text("Everything works.")).to_be_visible()
    expect(page.get_by_text("Drag the dot in the circle")).to_be_visible()


def test_a_slow_connection_is_explained_with_its_figures(browser: Browser, server: Server) -> None:
    study = FakeStudy.at(fake.input_check(rtt_ms=0.001), fake.code())
    study.refusals["/next"] = (422, "slow", "too slow")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        expect(page.get_by_role("alert")).to_contain_text("for a round trip; this study needs")
        assert violations(page) == []
        expect(page.get_by_role("button", name="Stop the study")).to_be_visible()
