"""How smoothly three browser engines draw the game without a GPU, and how far the picture lags behind the server.

In each of Chromium, Firefox and WebKit a player drives around with keys beside the scripted partner; targets: gap
between two pictures p50 <= 20 ms, p99 <= 40 ms, and in Chromium p99 < 25 ms. A blank page of the same engine says what
the machine allows. In Chromium a spectator looks on as well, and the drawing itself is timed.
"""

import itertools
import time

from playwright.sync_api import Page, sync_playwright

from tests.browser.engines import Tab, click_on, missing, open_tab, press, take_seats, wait_until
from tests.browser.support import (
    Server,
    frame_gaps,
    launch,
    seat_tokens_script,
    start,
    temporary_server,
    wait_for,
)

SECONDS = 20.0
KEYS = ("KeyW", "KeyD", "KeyS", "KeyA")
BLANK_GAPS = """new Promise((resolve) => {
  const [gaps, begun] = [[], performance.now()];
  let last = begun;
  const frame = (now) => {
    gaps.push(now - last);
    last = now;
    if (now - begun < 4000) requestAnimationFrame(frame);
    else resolve(gaps.slice(30));  // without the beginning of the page
  };
  requestAnimationFrame(frame);
})"""
DRAW_TIMES = """() => new Promise((resolve) => {
  const times = [];
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (...how) {  // the first call of each frame
    const begun = performance.now();
    queueMicrotask(() => times.push(performance.now() - begun));
    return draw.apply(this, how);
  };
  setTimeout(() => resolve(times.sort((a, b) => a - b)), 3000);
})"""


def main() -> None:
    for engine in ("chromium", "firefox", "webkit"):
        sentence = missing(engine)
        if sentence:
            print(f"browser, {engine}: {sentence}")
            continue
        with temporary_server() as server, open_tab(engine) as tab:
            _measure_engine(engine, server, tab)
    _measure_chromium()


def _measure_engine(engine: str, server: Server, tab: Tab) -> None:
    tab.goto(f"{server.url}/static/theme.js")
    blank = _middle_and_slowest(tab.evaluate(BLANK_GAPS))
    take_seats(tab, server.url, server.make_room("AdaptiveAssist", red="scripted"))
    click_on(tab, "#ready button")
    wait_until(tab, "window.__movingout.phase === 'playing'")
    tab.evaluate("void (window.__movingout.gaps.length = 0)")
    begun = time.monotonic()
    for key in itertools.cycle("wdsa"):
        if time.monotonic() > begun + SECONDS:
            break
        press(tab, key, hold_s=0.5)
    played = _middle_and_slowest(tab.evaluate("window.__movingout.gaps"))
    side = tab.evaluate("document.querySelector('#arena').width")
    print(f"browser, {engine}: gap between pictures {played} with an arena of {side} px; blank page {blank}")


def _middle_and_slowest(gaps: list[float]) -> str:
    ordered = sorted(gaps)
    middle, slowest = ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))]
    return f"p50 {middle:.1f} ms, p99 {slowest:.1f} ms"


def _measure_chromium() -> None:
    with temporary_server() as server, sync_playwright() as playwright:
        browser = launch(playwright)
        room = server.make_room("AdaptiveAssist", red="scripted")
        context = browser.new_context(base_url=server.url)
        context.add_init_script(seat_tokens_script(room))
        player, watcher = context.new_page(), browser.new_context(base_url=server.url).new_page()
        player.goto(room["join_path"])
        watcher.goto(room["watch_path"])
        start(player)
        wait_for(watcher, "game.phase === 'playing'")
        for page in (player, watcher):
            page.evaluate("window.__movingout.gaps.length = 0")
        _drive_about(player)
        for name, page in (("player", player), ("watcher", watcher)):
            middle, slowest = frame_gaps(page)
            behind = page.evaluate("window.__movingout.delayMs")
            count = page.evaluate("window.__movingout.gaps.length")
            print(
                f"browser, {name}: frame gap p50 {middle:.1f} ms, p99 {slowest:.1f} ms over {count} frames; "
                f"picture {behind:.0f} ms behind the server"
            )
        times = player.evaluate(DRAW_TIMES)
        middle, slowest = times[len(times) // 2], times[int(0.99 * (len(times) - 1))]
        print(f"browser, player: drawing and text p50 {middle:.1f} ms, p99 {slowest:.1f} ms")
        browser.close()


def _drive_about(page: Page) -> None:
    steps = int(SECONDS / 0.5)
    for key in itertools.islice(itertools.cycle(KEYS), steps):
        page.keyboard.down(key)
        page.wait_for_timeout(500)
        page.keyboard.up(key)
