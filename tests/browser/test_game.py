"""Two people at real browsers play whole games by pressing keys."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.pilot import Pilot, Plan, play
from tests.browser.support import Server, frame_gaps, seat_tokens_script, start, wait_for

OpenPage = Callable[..., Page]

BLUE_ON_SIMPLE: Plan = [("grab", 0), ("deliver", 0, -0.9, 0.9), ("grab", 2), ("deliver", 2, -0.8, 0.9)]
RED_ON_SIMPLE: Plan = [("grab", 1), ("deliver", 1, 0.9, 0.9)]


@pytest.mark.slow
def test_two_browsers_play_a_whole_game_by_key_presses(
    server: Server, open_page: OpenPage, pictures: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room = server.make_room("Simple", limit_ticks=1500)  # time to spare on a busy machine
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    start(blue, red)
    play(Pilot(blue, 0, BLUE_ON_SIMPLE), Pilot(red, 1, RED_ON_SIMPLE), timeout_s=155)
    assert blue.evaluate("window.__movingout.result.outcome") == "delivered"
    expect(blue.locator("#result")).to_contain_text("You delivered everything!")
    expect(blue.locator(".delivery-who")).to_have_text(["BYou", "RPartner", "BYou"])
    expect(red.locator("#done")).to_have_text("3 / 3")
    blue.screenshot(path=pictures / "result.png")
    middle, slowest = frame_gaps(blue)
    with capsys.disabled():
        print(f" frame gap p50 {middle:.1f} ms, p99 {slowest:.1f} ms ", end="")  # noqa: T201
    assert middle < 20

    expect(blue.get_by_role("button", name="Next map")).to_have_count(0)  # the other person would not come along
    blue.get_by_role("button", name="Answer 10 questions").click()
    expect(blue.locator("#after fieldset").first).to_be_visible()
    expect(blue.locator("#play")).to_be_hidden()


@pytest.mark.slow
def test_a_series_goes_on_to_the_next_map_when_both_are_ready(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("", red="idle", limit_ticks=20, maps=("HandOff", "LeftRight"))
    blue = open_page(room["join_path"], room)
    start(blue)
    expect(blue.locator("#round")).to_have_text("Round 1 of 2")
    wait_for(blue, "game.phase === 'round_over'")
    expect(blue.get_by_role("link", name="To the start page").first).to_be_visible()  # nobody has to play on
    blue.get_by_role("button", name="Next map").click()
    expect(blue.locator("#title")).to_have_text("Left Right")
    expect(blue.locator("#result")).to_be_hidden()
    wait_for(blue, "game.phase === 'series_over'")
    blue.get_by_role("button", name="Play again").click()
    wait_for(blue, "game.phase === 'playing'")
    expect(blue.locator("#title")).to_have_text("Left Right")


@pytest.mark.slow
def test_shortcuts_of_the_browser_neither_pause_nor_go_on(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page("/healthz")
    page.context.add_init_script(seat_tokens_script(room))
    sent: list[str | bytes] = []
    page.on("websocket", lambda line: line.on("framesent", lambda message: sent.append(message)))
    page.goto(room["join_path"])
    start(page)
    sent.clear()
    for phase in ("paused", "playing"):
        for modifier in ("Control", "Control+Shift", "Meta", "Alt"):
            page.keyboard.press(f"{modifier}+KeyP")
        page.keyboard.press("KeyP")
        wait_for(page, f"game.phase === '{phase}'")
    asked = [json.loads(message)["type"] for message in sent if isinstance(message, str)]
    assert [kind for kind in asked if kind in ("pause", "ready")] == ["pause", "ready"]


def test_a_scripted_partner_plays_along(server: Server, open_page: OpenPage, pictures: Path) -> None:
    room = server.make_room("AdaptiveAssist", red="scripted")
    blue = open_page(room["join_path"], room, device_scale_factor=2)
    expect(blue.locator("#seats")).to_contain_text("Computer partner")
    start(blue)
    blue.keyboard.down("KeyA")
    wait_for(blue, "game.entities().robots[1].held >= 0", 30)
    blue.screenshot(path=pictures / "game.png")
    blue.emulate_media(color_scheme="dark")
    wait_for(blue, "game.entities().items.some((item) => item.delivered)", 30)
    blue.screenshot(path=pictures / "game-dark.png")
    blue.keyboard.up("KeyA")
    assert blue.evaluate("document.querySelector('#arena').width") == 2 * blue.evaluate(
        "document.querySelector('#arena').clientWidth"
    ), "crisp on a screen of double density"


def down_the_pathway(item: int) -> Plan:
    """On HandOff: fetch an item from the top left, turn at the top of the pathway and push the item down."""
    steps: Plan = [
        ("drive", "left", "x", -0.04),
        ("drive", "up", "y", 0.8),
        ("grab", item),
        ("back", -0.08, 0.88, 0.07),
        ("back", 0.1, 0.79, 0.05),
        ("drive", "down", "y", 0.2),
        ("shove", "down"),
        ("drop",),
        ("drive", "up", "y", 0.4),
    ]
    return [("until", item, 180, steps)]


@pytest.mark.slow
def test_two_browsers_play_hand_off_to_the_end_by_key_presses(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("HandOff", limit_ticks=2000)
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    start(blue, red)
    aside: Plan = [("drive", "up", "y", 0.9), ("drive", "right", "x", 0.1), ("drive", "up", "y", 1.05)]
    carry = [step for item in (2, 3, 1, 0) for step in down_the_pathway(item)]
    play(Pilot(blue, 0, carry), Pilot(red, 1, aside), timeout_s=230)
    assert blue.evaluate("window.__movingout.result.outcome") == "delivered"
    expect(red.locator("#result")).to_contain_text("You delivered everything!")
