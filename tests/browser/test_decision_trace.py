"""The watch page looks into an agent that weighs candidates."""

import json
import math
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import OpenPage
from tests.browser.pages import violations
from tests.browser.support import DESKTOP, PHONE, Server, start, wait_for

TRACE = {
    "seat": 0,
    "tick": 4,
    "chosen": 1,
    "scores": [0.12, 0.34, 0.2, 0.1],
    "candidates": [[[1.0, math.cos(angle), math.sin(angle)]] * 8 for angle in (0.0, 0.8, 1.6, 2.4)],
    "items": [[[0.2 * number, 0.1]] for number in range(4)],
    "guesses": [[[1.0, math.cos(angle), math.sin(angle)]] * 8 for angle in (-0.5, 0.5)],
    "pairs": [[own, guess] for own in range(4) for guess in range(2)],
    "robots": [
        [[[0.1 * own, -0.3], [0.2 * guess, 0.4]], [[0.2 * own, -0.1], [0.4 * guess, 0.6]]]
        for own in range(4)
        for guess in range(2)
    ],
}


def weigh(page: Page, *traces: dict[str, object]) -> None:
    """The server tells of these decisions whenever the page asks, and that there are any."""
    page.route("**/api/rooms/*", lambda route: route.fulfill(json={"weighs": True}))
    stream = "retry: 300\n" + "".join(f"data: {json.dumps(trace)}\n\n" for trace in traces)
    page.route("**/thoughts", lambda route: route.fulfill(content_type="text/event-stream", body=stream))


@pytest.mark.slow
def test_a_spectator_switches_on_what_an_agent_weighs(server: Server, open_page: OpenPage, pictures: Path) -> None:
    room = server.make_room("HandOff", blue="idle", red="scripted")  # lasts until time is up
    page = open_page(room["watch_path"])
    weigh(page, TRACE)
    box = page.get_by_role("region", name="What agents consider")
    box.get_by_role("button", name="Show options").click()
    rows = box.get_by_role("listitem")
    expect(rows).to_have_count(4)
    expect(rows.first).to_have_text("10.340chosen")  # the rank, the score
    expect(box).to_contain_text("1 has the highest score")
    page.screenshot(path=pictures / "decision-trace.png")
    assert violations(page) == []
    box.get_by_role("button", name="Hide options").click()
    expect(box.get_by_role("listitem")).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_switch_stays_under_the_pointer_when_the_round_begins(
    server: Server, open_page: OpenPage, size: dict[str, int]
) -> None:
    room = server.make_room("HandOff", blue="here", red="idle")
    page = open_page(room["watch_path"], viewport=size)
    weigh(page, TRACE)
    expect(page.locator("#ready")).to_be_visible()  # and gone when the round begins
    page.get_by_role("button", name="Show options").hover()
    page.mouse.down()
    start(open_page(room["join_path"], room))
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator("#ready")).to_be_hidden()
    expect(page.get_by_role("button", name="Show options")).to_be_focused()  # there is no key here that grabs
    page.mouse.up()
    expect(page.locator("#decisions").get_by_role("listitem")).to_have_count(4)
    page.mouse.down()  # the scores have not moved it either
    page.mouse.up()
    expect(page.get_by_role("button", name="Show options")).to_be_visible()


@pytest.mark.slow
def test_where_no_agent_weighs_nothing_is_offered(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("SingleRotation", blue="idle", red="scripted")
    page = open_page(room["watch_path"])
    wait_for(page, "game.phase === 'playing' && game.tick > 5")
    assert server.request(f"/api/rooms/{room['room']}")["weighs"] is False
    expect(page.locator("#decisions")).to_be_hidden()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "dark"), [(DESKTOP, True), ({"width": 375, "height": 553}, False)], ids=["desktop", "phone"]
)
def test_a_real_agent_that_weighs_is_offered_and_shown(
    server: Server, open_page: OpenPage, pictures: Path, size: dict[str, int], dark: bool
) -> None:
    room = server.make_room("LeftRight", blue="bass@all", red="scripted")
    page = open_page(room["watch_path"], viewport=size, color_scheme="dark" if dark else "light")
    page.get_by_role("button", name="Show options").click(timeout=60_000)
    box = page.locator("#decisions")
    expect(box.get_by_role("listitem").first).to_contain_text("1")
    page.screenshot(path=pictures / f"candidates-{size['width']}-{'dark' if dark else 'light'}.png")


def test_players_are_not_offered_to_look_into_their_partner(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    expect(page.locator("#decisions")).to_be_hidden()


@pytest.mark.slow
def test_in_a_pause_stays_what_was_weighed_last(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("HandOff", blue="here", red="idle")
    page, blue = open_page(room["watch_path"]), open_page(room["join_path"], room)
    weigh(page, TRACE)
    start(blue)
    page.get_by_role("button", name="Show options").click()
    scores = page.locator("#decisions").get_by_role("listitem")
    expect(scores).to_have_count(4)
    blue.keyboard.press("Escape")
    wait_for(page, "game.phase === 'paused'")
    weigh(page)  # nothing any more
    page.wait_for_timeout(2500)
    expect(scores).to_have_count(4)
    blue.keyboard.press("Space")
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator("#decisions")).to_contain_text("These players do not show their plans.")
