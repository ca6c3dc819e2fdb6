"""How smoothly three browser engines draw the game without a GPU, and how far the picture lags behind the server.

In each of Chromium, Firefox and WebKit a player drives around with keys beside the scripted partner; targets: gap
between two pictures p50 <= 20 ms, p99 <= 40 ms, and in Chromium p99 < 25 ms. WebKit is measured a second time with a
graphics processor that Mesa emulates, which is how WebKitGTK comes. What the machine allows is said by two
other pages of the same engine: a blank one, and one on which nothing but a square of 20 pixels moves. In Chromium a
spectator looks on as well, the drawing itself is timed, and so is the first paint of the lobby (target: 0.5 s).
"""

import itertools
import time

from playwright.sync_api import Browser, Page, sync_playwright

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
GAPS = """new Promise((resolve) => {
  const [gaps, begun] = [[], performance.now()];
  let last = begun;
  const square = document.createElement("div");
  Object.assign(square.style, { position: "fixed", width: "20px", height: "20px", background: "red" });
  document.body.replaceChildren(...(MOVES ? [square] : []));
  const frame = (now) => {
    gaps.push(now - last);
    last = now;
    square.style.left = `${(now / 10) % 600}px`;
    if (now - begun < 4000) requestAnimationFrame(frame);
    else resolve(gaps.slice(30));  // without the beginning of the page
  };
  requestAnimationFrame(frame);
})"""
LOBBY_TIMES = """new Promise((resolve) => {
  const ready = () => document.querySelectorAll("#maps:not([aria-busy=true]) canvas").length >= 12;
  const look = () => {
    const [paint] = performance.getEntriesByName("first-contentful-paint");
    if (paint && ready()) resolve([paint.startTime, performance.now()]);
    else setTimeout(look, 5);
  };
  look();
})"""
LOBBY_VISITS = 9
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
    for engine, emulated_gpu in (("chromium", False), ("firefox", False), ("webkit", False), ("webkit", True)):
        sentence = missing(engine)
        if sentence:
            print(f"browser, {engine}: {sentence}")
            continue
        with temporary_server() as server, open_tab(engine, emulated_gpu=emulated_gpu) as tab:
            _measure_engine(f"{engine} with an emulated GPU" if emulated_gpu else engine, server, tab)
    _measure_chromium()


def _measure_engine(engine: str, server: Server, tab: Tab) -> None:
    tab.goto(f"{server.url}/static/theme.js")
    blank, square = (_middle_and_slowest(tab.evaluate(GAPS.replace("MOVES", moves))) for moves in ("false", "true"))
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
    print(f"browser, {engine}: gap between pictures {played} with an arena of {side} px")
    print(f"browser, {engine}: blank page {blank}; nothing but a small square moves {square}")


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
        _measure_lobby(server, browser)
        browser.close()


def _measure_lobby(server: Server, browser: Browser) -> None:
    """Of visits with an empty cache, each in a browser profile of its own."""
    paints, readies = [], []
    for _ in range(LOBBY_VISITS):
        context = browser.new_context(base_url=server.url)
        page = context.new_page()
        page.goto("/", wait_until="commit")
        paint_ms, ready_ms = page.evaluate(LOBBY_TIMES)
        paints.append(paint_ms)
        readies.append(ready_ms)
        context.close()
    for name, times in (("first paint", paints), ("all maps drawn", readies)):
        print(f"browser, lobby: {name} after {sorted(times)[len(times) // 2]:.0f} ms, at most {max(times):.0f} ms")


def _drive_about(page: Page) -> None:
    steps = int(SECONDS / 0.5)
    for key in itertools.islice(itertools.cycle(KEYS), steps):
        page.keyboard.down(key)
        page.wait_for_timeout(500)
        page.keyboard.up(key)
