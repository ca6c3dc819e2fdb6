"""What people see when the network or the server fails, and that they get their game back."""

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, WebSocketRoute, expect

from tests.browser.pages import complaining_page, violations
from tests.browser.support import (
    DESKTOP,
    STORAGE_FORBIDDEN,
    Server,
    free_port,
    robot,
    seat_tokens_script,
    start,
    start_process,
    stop_process,
    wait_for,
)

OpenPage = Callable[..., Page]
NARROW: ViewportSize = {"width": 375, "height": 553}


@pytest.mark.slow
def test_a_line_that_goes_dumb_stops_the_picture_with_a_sign_and_catches_up(
    server: Server, open_page: OpenPage
) -> None:
    room = server.practice()
    page = open_page("/healthz")
    page.context.add_init_script(seat_tokens_script(room))
    dumb = False

    def between(line: WebSocketRoute) -> None:
        upstream = line.connect_to_server()
        upstream.on_message(lambda message: None if dumb else line.send(message))

    page.route_web_socket("**/ws/*", between)
    page.goto(room["join_path"])
    start(page)
    page.keyboard.down("KeyW")
    wait_for(page, "game.entities().robots[0].y > -0.9")
    expect(page.locator("#stalled")).to_be_hidden()
    dumb = True
    wait_for(page, "game.stalled")
    expect(page.locator("#stalled")).to_be_visible()
    expect(page.locator("#connection")).to_have_text("stalled")
    stood = robot(page, 0)["y"]
    dumb = False
    wait_for(page, f"!game.stalled && game.entities().robots[0].y > {stood + 0.05}")
    expect(page.locator("#stalled")).to_be_hidden()
    page.keyboard.up("KeyW")


@pytest.mark.slow
def test_without_a_line_a_phone_offers_no_controls_and_has_them_again_afterwards(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.practice()
    page = open_page("/healthz", viewport=NARROW, has_touch=True, is_mobile=True, locale="de-DE")
    page.context.add_init_script(seat_tokens_script(room))
    lines: list[WebSocketRoute] = []
    is_down = False

    def between(line: WebSocketRoute) -> None:
        lines.append(line)
        if is_down:
            line.close(code=1012)
        else:
            line.connect_to_server()

    page.route_web_socket("**/ws/*", between)
    page.goto(room["join_path"])
    page.locator("#ready .button-primary").tap()
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator("#touch-grab")).to_be_visible()
    is_down = True
    lines[-1].close(code=1012)
    expect(page.locator("#overlay")).to_contain_text("Verbindung verloren. Neuer Versuch …")
    expect(page.locator("#touch")).to_be_hidden()
    expect(page.locator("#stop")).to_be_disabled()
    page.screenshot(path=pictures / "lost-de-375.png")
    page.set_viewport_size({"width": 568, "height": 320})
    page.screenshot(path=pictures / "lost-de-568.png")
    is_down = False
    expect(page.locator("#touch-grab")).to_be_visible()
    expect(page.locator("#stop")).to_be_enabled()


@pytest.mark.slow
def test_after_a_kill_and_a_restart_both_are_back_in_their_seats(browser: Browser, tmp_path: Path) -> None:
    server = Server(f"http://127.0.0.1:{free_port()}", tmp_path / "data", tmp_path / "server.log")
    process = start_process(server)
    try:
        room = server.make_room("Simple")
        blue = browser.new_context(base_url=server.url, viewport=DESKTOP).new_page()  # type: ignore[arg-type]
        blue.context.add_init_script(seat_tokens_script(room))
        red = browser.new_context(base_url=server.url, viewport=DESKTOP).new_page()  # type: ignore[arg-type]
        for page in (blue, red):
            page.goto(room["join_path"])
        start(blue, red)
        blue.keyboard.down("KeyW")
        wait_for(blue, "game.tick > 20")
        blue.keyboard.up("KeyW")
        process.kill()
        process.wait()
        expect(blue.locator("#connection")).to_have_text("lost")
        expect(blue.locator("#overlay")).to_contain_text("Connection lost. Trying again…")
        tick = blue.evaluate("window.__movingout.tick")
        process = start_process(server)
        for page in (blue, red):
            wait_for(page, "game.status === 'open' && game.phase !== 'playing'", 30)
        for page in (blue, red):
            if page.evaluate("window.__movingout.phase") == "paused":
                page.wait_for_timeout(900)
                page.keyboard.press("Space")
        for page in (blue, red):
            wait_for(page, f"game.phase === 'playing' && game.tick > {tick}", 30)
        assert [page.evaluate("window.__movingout.seats") for page in (blue, red)] == [[0], [1]]
    finally:
        stop_process(process)


@pytest.mark.slow
def test_the_pause_and_the_settings_have_no_fault_for_assistive_technology(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    room = server.practice(red="here")
    page = open_page(room["join_path"], room)
    start(page, page)
    assert violations(page) == []
    page.get_by_role("button", name="Change…").click()
    expect(page.locator("#settings")).to_be_visible()
    page.screenshot(path=pictures / "settings.png")
    assert violations(page) == []
    page.get_by_role("button", name="Done").click()
    expect(page.locator("#overlay")).to_contain_text("Paused")
    assert violations(page) == []


def test_where_a_browser_keeps_nothing_the_lobby_says_so_and_a_link_still_plays(
    server: Server, open_page: OpenPage
) -> None:
    page = open_page("/", script=STORAGE_FORBIDDEN)
    page.get_by_role("button", name="Play now").click()
    expect(page.get_by_text("This browser may not keep data for this page. Allow cookies")).to_be_visible()
    assert page.url == f"{server.url}/"
    room = server.make_room("HandOff", blue="link", red="idle")
    guest = open_page(room["join_path"], script=STORAGE_FORBIDDEN)
    start(guest)


def test_a_refused_practice_is_said_beside_its_button_and_what_was_said_before_is_gone(
    browser: Browser, server: Server
) -> None:
    with complaining_page(browser, server, "/", viewport={"width": 375, "height": 553}) as page:
        page.route("**/api/rooms", lambda route: route.abort())
        for button, box in (("#play-now", "#first-problem"), ("#practice", "#practice-problem")):
            page.locator(button).click()
            expect(page.locator(box)).to_be_in_viewport(ratio=1)
            expect(page.locator(".notice-bad:visible")).to_have_count(1)


@pytest.mark.slow
@pytest.mark.parametrize("language", ["de-DE", "en-GB"])
def test_while_a_server_lets_its_rounds_end_who_is_ready_reads_why_nothing_begins(
    browser: Browser, tmp_path: Path, pictures: Path, language: str
) -> None:
    why = {"de-DE": "Der Server startet gleich neu", "en-GB": "The server restarts in a moment"}[language]
    server = Server(f"http://127.0.0.1:{free_port()}", tmp_path / "data", tmp_path / "server.log")
    process = start_process(server)
    try:
        playing, lobby = server.make_room("Simple", red="idle", limit_ticks=900), server.make_room("Simple", red="idle")
        result = server.make_room("Simple", red="idle", maps=("Simple", "HandOff"), limit_ticks=15)
        last = server.make_room("Simple", red="idle", limit_ticks=15)
        pages = []
        for room in (playing, lobby, result, last):
            page = browser.new_context(base_url=server.url, viewport=NARROW, locale=language).new_page()
            page.context.add_init_script(seat_tokens_script(room))
            page.goto(room["join_path"])
            pages.append(page)
        for page in (pages[0], *pages[2:]):
            page.locator("#ready .button-primary").click()
        wait_for(pages[0], "game.phase === 'playing'")
        wait_for(pages[2], "game.phase === 'round_over'")
        wait_for(pages[3], "game.phase === 'series_over'")
        process.send_signal(signal.SIGUSR1)
        pages[1].locator("#ready .button-primary").click()
        expect(pages[1].locator("#ready")).to_contain_text(why)
        for page, way in ((pages[2], 0), (pages[3], 1)):  # the next round, and the only one again
            page.locator(".result-ways button").nth(way).click()
            expect(page.locator(".result-company")).to_contain_text(why)
            expect(page.locator(".result-company")).to_be_in_viewport()
            assert page.get_by_role("heading", level=1).is_visible(), "the result stays"
        for name, page in zip(("lobby", "result"), pages[1:3], strict=True):
            for width, height in ((375, 553), (568, 320)):
                page.set_viewport_size({"width": width, "height": height})
                page.screenshot(path=pictures / f"restart_soon-{name}-{language}-{width}.png")
    finally:
        process.kill()
        process.wait(timeout=20)
