"""Who is there: partners who drop out and come back, spectators, people without a seat, pages that are too old."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from movingout.server.rooms.time_limits import PAUSES
from tests.browser.pages import admin_token, violations
from tests.browser.support import Server, complaints, start, wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]


def test_a_player_who_drops_out_comes_back_to_the_same_seat_and_the_partner_is_told(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.practice(red="link")
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    expect(red.locator("#seats")).to_contain_text("getting ready")
    start(blue, red)
    wait_for(blue, "game.tick > 5")
    tick = blue.evaluate("window.__movingout.tick")
    blue.goto("about:blank")
    wait_for(red, "game.phase === 'paused'")
    expect(red.locator("#overlay")).to_contain_text("Blue lost the connection")
    expect(red.locator("#overlay")).to_contain_text("Blue has")
    expect(red.locator("#seats")).to_contain_text("reconnecting…")
    red.screenshot(path=pictures / "paused.png")
    blue.goto(room["join_path"])
    wait_for(blue, "game.phase === 'countdown' || game.phase === 'playing'")
    wait_for(blue, f"game.phase === 'playing' && game.tick > {tick}")
    assert blue.evaluate("window.__movingout.seats") == [0]


@pytest.mark.parametrize(
    ("width", "height", "language"), [(375, 553, "de-DE"), (360, 640, "en-GB"), (740, 360, "de-DE")]
)
def test_all_of_the_invitation_s_code_is_in_sight_on_a_phone(
    server: Server, open_page: OpenPage, width: int, height: int, language: str
) -> None:
    room = server.make_room("HandOff")
    phone = {"viewport": {"width": width, "height": height}, "is_mobile": True, "has_touch": True, "locale": language}
    page = open_page(room["join_path"], room, **phone)
    code, card = page.locator("#ready .qr"), page.locator("#ready")
    expect(code).to_be_visible()
    inner, outer = code.bounding_box(), card.bounding_box()
    assert inner is not None
    assert outer is not None
    assert outer["y"] <= inner["y"]
    assert inner["y"] + inner["height"] <= min(outer["y"] + outer["height"], height)


@pytest.mark.parametrize(
    ("width", "height"),
    [(375, 553), *(pytest.param(*size, marks=pytest.mark.slow) for size in [(320, 568), (1240, 760)])],
)
def test_where_the_host_left_before_the_round_everybody_reads_why_it_is_over(
    server: Server, open_page: OpenPage, pictures: Path, width: int, height: int
) -> None:
    small = {"viewport": {"width": width, "height": height}, "has_touch": width < 1000}
    room = server.make_room("HandOff")
    host = open_page(room["join_path"], room, **small)
    host.locator("#stop").click()
    host.get_by_role("button", name="Yes").click()
    expect(host).to_have_url(f"{server.url}/")
    guest = open_page(room["join_path"], **small)
    host.go_back()
    for page in (guest, host):
        expect(page.locator("#ready")).to_have_text("Blue left the game.To the start page")
        expect(page.locator("#live")).to_have_text("Blue left the game.")
        assert page.get_by_role("button", name="I am ready").count() == 0
    guest.screenshot(path=pictures / f"host-left-{width}.png")
    guest.get_by_role("link", name="To the start page").click()
    expect(guest).to_have_url(f"{server.url}/")


def test_a_tab_in_the_background_tells_by_its_title_that_the_partner_came(server: Server, open_page: OpenPage) -> None:
    room = server.practice(red="link")
    waiting = open_page(room["join_path"], room)
    expect(waiting.locator("#ready")).to_be_visible()
    title = waiting.title()
    _turn(waiting, hidden=True)
    open_page(room["join_path"])
    expect(waiting).to_have_title(f"● {title}")
    _turn(waiting, hidden=False)
    expect(waiting).to_have_title(title)


def _turn(page: Page, *, hidden: bool) -> None:
    """What a page sees when its tab goes to the background or comes back."""
    page.evaluate(
        "hidden => { Object.defineProperty(document, 'hidden', { value: hidden, configurable: true });"
        " document.dispatchEvent(new Event('visibilitychange')); }",
        hidden,
    )


def test_a_screen_reader_hears_that_the_partner_came_and_the_keyboard_is_where_it_was(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("HandOff")
    blue = open_page(room["join_path"], room)
    blue.get_by_role("button", name="Copy the link").focus()
    red = open_page(room["join_path"])
    expect(blue.locator("#live")).to_have_text("Partner: getting ready")
    expect(blue.get_by_role("button", name="I am ready")).to_be_focused()
    red.get_by_role("button", name="I am ready").click()
    expect(blue.locator("#live")).to_have_text("Partner: ready")
    blue.keyboard.press("Enter")
    expect(blue.locator("#live")).to_have_text("Get ready.")
    wait_for(blue, "game.phase === 'playing'")


def test_after_the_last_round_one_sees_whether_the_partner_plays_again_or_has_left(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("HandOff", limit_ticks=15)
    blue = open_page(room["join_path"], room)
    red = open_page(room["join_path"])
    start(blue, red)
    company = blue.locator(".result-company")
    red.get_by_role("button", name="Play again").click()
    expect(company).to_have_text("Partner: ready")
    red.close()
    expect(company).to_have_text("Partner: no longer here")
    expect(blue.locator("#live")).to_have_text("Partner: no longer here")
    blue.get_by_role("button", name="Play again").click()
    expect(blue.locator("#ready")).to_contain_text("Partner: no longer here")
    blue.get_by_role("link", name="To the start page").click()
    expect(blue).to_have_url(f"{server.url}/")


def test_after_the_last_round_a_phone_still_says_whose_the_partner_s_badge_is(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("HandOff", limit_ticks=15)
    phone = {"viewport": {"width": 360, "height": 640}, "is_mobile": True, "has_touch": True}
    blue, red = open_page(room["join_path"], room, **phone), open_page(room["join_path"])
    start(blue, red)
    partner = blue.locator("#seats .seat").nth(1)
    blue.get_by_role("button", name="Play again").click()
    expect(partner.locator(".seat-words")).to_be_empty()  # neither ready nor gone
    in_sight = "name => name.getBoundingClientRect().width > 20"
    assert partner.locator(".seat-name").evaluate(in_sight)
    red.close()
    expect(partner.locator(".seat-words")).to_have_text("no longer here")
    assert not partner.locator(".seat-name").evaluate(in_sight), "there is room for one of the two"


def test_who_closed_the_tab_and_opens_the_link_again_sits_where_they_sat(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("HandOff", blue="link", red="scripted")
    page = open_page(room["join_path"])
    start(page)
    page.keyboard.press("Escape")
    expect(page.locator("#overlay")).to_contain_text("You paused the game.")
    link, context = page.url, page.context
    page.close(run_before_unload=True)
    again = context.new_page()
    again.goto(link)
    wait_for(again, "game.status === 'open' && ['countdown', 'playing', 'paused'].includes(game.phase)")
    assert again.evaluate("window.__movingout.seats") == [0]


def test_escape_pauses_space_goes_on_and_stopping_asks_once_more(server: Server, open_page: OpenPage) -> None:
    room = server.practice(red="link")
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    red.get_by_role("button", name="I am ready").click()
    expect(blue.locator("#ready")).to_contain_text("Your partner is ready.")
    start(blue)
    blue.keyboard.press("Escape")
    wait_for(red, "game.phase === 'paused'")
    expect(red.locator("#overlay")).to_contain_text("Blue paused the game")
    blue.wait_for_timeout(1000)
    blue.keyboard.press("Space")
    wait_for(blue, "game.phase === 'playing'")
    blue.get_by_role("button", name="Pause or stop…").click()
    blue.get_by_role("button", name="Stop the game").press("Enter")
    expect(blue.get_by_role("heading", name="Stop the game for both of you?")).to_be_visible()
    expect(blue.get_by_role("button", name="No, go back")).to_be_focused()
    blue.keyboard.press("Enter")
    expect(blue.get_by_role("button", name="Continue")).to_be_focused()
    blue.get_by_role("button", name="Stop the game").click()
    blue.get_by_role("button", name="Yes, stop").click()
    wait_for(red, "game.phase === 'series_over'")
    expect(red.locator("#result")).to_be_visible()
    assert red.evaluate("window.__movingout.result.outcome") == "left"
    expect(blue.locator("#result")).to_be_visible()
    blue.wait_for_timeout(700)  # time for a wrong input and the complaint about it
    expect(blue.locator("#problem")).to_be_hidden()


def test_while_the_seconds_of_a_pause_run_the_keyboard_stays_where_it_is(server: Server, open_page: OpenPage) -> None:
    room = server.practice(red="link")
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    start(blue, red)
    blue.keyboard.press("Escape")
    expect(blue.locator("#overlay .invisible")).to_have_count(0)
    stop = [page.get_by_role("button", name="Stop the game") for page in (blue, red)]
    for button in stop:
        button.focus()
    seconds = blue.locator("#overlay").get_by_text("at the latest")
    shown = seconds.inner_text()
    expect(seconds).not_to_have_text(shown)
    for button in stop:
        expect(button).to_be_focused()
    stop[0].press("Enter")
    yes = blue.get_by_role("button", name="Yes, stop")
    yes.focus()
    red.wait_for_timeout(1100)
    expect(yes).to_be_focused()
    red.close()  # the pause has another reason, and the question stands
    expect(blue.locator("#seats")).to_contain_text("reconnecting…")
    expect(yes).to_be_focused()


def asked_whether_to_stop(room: dict[str, Any], open_page: OpenPage) -> Page:
    page = open_page(room["join_path"], room)
    start(page)
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").press("Enter")
    expect(page.get_by_role("button", name="No, go back")).to_be_focused()
    return page


def test_escape_answers_the_question_whether_to_stop_with_no(server: Server, open_page: OpenPage) -> None:
    page = asked_whether_to_stop(server.practice(), open_page)
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Continue")).to_be_focused()
    assert page.evaluate("window.__movingout.phase") == "paused"
    page.keyboard.press("Escape")
    wait_for(page, "game.phase === 'playing'")


def test_escape_leaves_the_words_that_the_game_is_over(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = asked_whether_to_stop(room, open_page)
    server.request(f"/api/admin/rooms/{room['room']}/close", {}, admin_token(server))
    over = page.locator("#overlay[data-kind=over]")
    expect(over).to_be_visible()
    page.keyboard.press("Escape")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    expect(over).to_be_visible()


def test_who_has_no_pauses_left_can_still_stop(server: Server, open_page: OpenPage, pictures: Path) -> None:
    """Stopping is behind the pause: without one nobody could end the game but by closing the page."""
    room = server.practice(red="link")
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    start(blue, red)
    for _ in range(PAUSES):
        red.keyboard.press("Escape")
        wait_for(red, "game.phase === 'paused'")
        red.get_by_role("button", name="Continue").click()
        wait_for(red, "game.phase === 'playing'")
    red.keyboard.press("Escape")
    expect(red.get_by_role("heading", name="Stop the game for both of you?")).to_be_visible()
    expect(red.locator("#problem")).to_contain_text("You have used up your pauses of this round.")
    red.screenshot(path=pictures / "no-pauses-left.png")
    assert red.evaluate("window.__movingout.phase") == "playing"
    red.get_by_role("button", name="No, go back").click()
    expect(red.locator("#overlay")).to_be_hidden()
    red.get_by_role("button", name="Pause or stop…").click()
    red.get_by_role("button", name="Yes, stop").click()
    wait_for(blue, "game.phase === 'series_over'")


def test_who_leaves_before_the_game_is_back_at_the_start_page_and_the_seat_is_free(
    server: Server, open_page: OpenPage
) -> None:
    room = server.practice(red="link")
    blue, red = open_page(room["join_path"], room), open_page(room["join_path"])
    red.get_by_role("button", name="Leave").click()
    red.get_by_role("button", name="Yes, stop").click()
    red.wait_for_url(server.url + "/")
    expect(blue.locator("#ready")).to_contain_text("Waiting for your partner")


def test_a_spectator_sees_the_game_and_has_nothing_to_press(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    player = open_page(room["join_path"], room)
    watcher = open_page(room["watch_path"])
    start(player)
    player.keyboard.down("KeyW")
    wait_for(watcher, "game.phase === 'playing' && game.entities().robots[0].y > -0.8")
    player.keyboard.up("KeyW")
    expect(watcher.locator("#watchers")).to_have_text("You are watching.")
    expect(watcher.locator("#controls")).to_be_hidden()
    expect(player.locator("#watchers")).to_have_text("1 person is watching.")


def test_somebody_without_a_free_seat_is_told_and_may_watch(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"])
    expect(page.locator("#overlay")).to_contain_text("This room is full")
    page.get_by_role("link", name="Watch").click()
    wait_for(page, "game.status === 'open'")


def test_who_opens_the_invitation_again_is_told_of_their_other_tab_and_can_play_here_instead(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("HandOff")
    open_page(room["join_path"], room)
    friend = open_page(room["join_path"])
    wait_for(friend, "game.status === 'open'")
    again = friend.context.new_page()
    heard = complaints(again)
    again.goto(room["join_path"])
    expect(again.get_by_role("alert")).to_contain_text("already in this game in another tab")
    wait_for(friend, "game.status === 'open'")  # it has lost nothing yet
    again.get_by_role("button", name="Play here instead").click()
    wait_for(again, "game.status === 'open' && game.seats.join() === '1'")
    expect(friend.get_by_role("alert")).to_contain_text("You continued in another window")
    stranger = open_page(room["join_path"])  # another browser
    expect(stranger.get_by_role("alert")).to_contain_text("This room is full")
    stranger.wait_for_timeout(700)
    expect(stranger.get_by_role("alert")).to_contain_text("This room is full")
    assert heard == []


def test_a_link_that_leads_nowhere_says_so(open_page: OpenPage) -> None:
    page = open_page("/play/nosuchroom22")
    expect(page.get_by_role("alert")).to_be_visible()
    expect(page.get_by_role("link", name="To the start page")).to_be_visible()


def test_on_a_phone_nothing_lies_over_what_is_said_of_a_link_that_leads_nowhere(open_page: OpenPage) -> None:
    page = open_page("/play/nosuchroom22", viewport={"width": 375, "height": 553}, has_touch=True, is_mobile=True)
    expect(page.get_by_role("alert")).to_be_visible()
    at_its_top = """() => {
      const panel = document.querySelector("#overlay .panel");
      const { left, top, width } = panel.getBoundingClientRect();
      return panel.contains(document.elementFromPoint(left + width / 2, top + 2));
    }"""
    assert page.evaluate(at_its_top)


def test_a_page_of_another_protocol_asks_to_be_reloaded(server: Server, open_page: OpenPage) -> None:
    def older(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, body=answer.text().replace("PROTOCOL = 1", "PROTOCOL = 99"))

    room = server.practice()
    page = open_page("/healthz")
    page.route("**/messages.js", older)
    page.goto(room["watch_path"])
    expect(page.get_by_role("alert")).to_contain_text("Please reload it")
    expect(page.get_by_role("button", name="Reload")).to_be_visible()


PARTS_OF_A_ROUND = "#time-bar, #done-bar, #seats, #stop, #connection, #arena"


def test_a_room_that_lets_nobody_in_shows_nothing_but_why(server: Server, open_page: OpenPage) -> None:
    taken = server.make_room("HandOff", red="idle")["join_path"]
    phone = {"viewport": {"width": 375, "height": 553}, "is_mobile": True, "has_touch": True}
    for path, text in (("/play/aaaaaaaaaaaa", "no longer exists"), (taken, "This room is full")):
        for window in ({}, phone):
            page = open_page(path, **window)
            expect(page.get_by_role("alert")).to_contain_text(text)
            expect(page.locator(PARTS_OF_A_ROUND).filter(visible=True)).to_have_count(0)
            middle = page.locator("#overlay").bounding_box()
            assert middle is not None
            assert abs(middle["y"] + middle["height"] / 2 - page.evaluate("innerHeight") / 2) < 40


def test_the_invitation_has_a_link_a_code_and_no_fault_for_assistive_technology(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.make_room("HandOff")
    page = open_page(room["join_path"], room)
    expect(page.locator("#ready")).to_contain_text("Waiting for your partner")
    assert page.locator("#ready input").input_value() == server.url + room["join_path"]
    page.wait_for_function("() => document.querySelector('#ready img')?.naturalWidth > 0")
    page.screenshot(path=pictures / "waiting.png")
    assert violations(page) == []
    page.screenshot(path=pictures / "waiting-dark.png")


def test_before_a_map_that_an_agent_never_saw_everybody_in_the_room_is_told(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("Simple", blue="idle", red="mlp@all")
    problem = open_page(room["watch_path"]).locator("#problem")
    expect(problem).to_have_text(
        "Trained partner (MLP) was not trained on this map and may play badly.", timeout=20_000
    )
    expect(problem).to_have_class("notice notice-attention small play-problem")
