"""Takes the pictures of the documentation from a running server: `python -m tests.browser.documentation_pictures`.

Nothing in them is made up: rooms are opened, played and replayed on a server of this run. They are small PNG files of
few colours in docs/images.
"""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from tests.browser.pages import admin_token
from tests.browser.support import Server, launch, seat_tokens_script, start, temporary_server, wait_for

FOLDER = Path(__file__).parents[2] / "docs" / "images"
DESKTOP = {"width": 1240, "height": 760}
PHONE: dict[str, Any] = {"viewport": {"width": 375, "height": 640}, "has_touch": True, "is_mobile": True}
COLOURS = 128
MOST_BYTES = 150_000

OpenPage = Callable[..., Page]


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    with temporary_server() as server, sync_playwright() as playwright:
        browser = launch(playwright)
        for take in (_lobby, _game, _phone, _company):
            take(server, _opener(browser, server))
            server.close_rooms(admin_token(server))
        browser.close()


def _opener(browser: Browser, server: Server) -> OpenPage:
    def open_page(path: str, room: dict[str, Any] | None = None, **options: Any) -> Page:
        context = browser.new_context(base_url=server.url, **{"viewport": DESKTOP, **options})
        if room is not None:
            context.add_init_script(seat_tokens_script(room))
        page = context.new_page()
        page.goto(path)
        return page

    return open_page


def _lobby(server: Server, open_page: OpenPage) -> None:
    for name, options in (("lobby", {}), ("lobby-dark", {"color_scheme": "dark"}), ("lobby-phone", PHONE)):
        page = open_page("/", **options)
        page.locator("#play-now:not([disabled])").wait_for()
        _keep(page, name)


def _game(server: Server, open_page: OpenPage) -> None:
    """A round beside the scripted partner, its result, and the replay of it."""
    room = server.make_room("AdaptiveAssist", red="scripted")
    page = open_page(room["join_path"], room)
    page.get_by_role("button", name="I am ready").wait_for()
    _keep(page, "ready")
    start(page)
    page.keyboard.down("KeyA")
    wait_for(page, "game.entities().robots[1].held >= 0", 40)
    page.keyboard.up("KeyA")
    wait_for(page, "game.entities().items.some((item) => item.delivered)", 60)
    _keep(page, "game")
    page.emulate_media(color_scheme="dark")
    _keep(page, "game-dark")
    page.emulate_media(color_scheme="light")
    wait_for(page, "game.phase === 'series_over'", 90)
    page.locator(".deliveries").wait_for()
    _keep(page, "result")
    replay = open_page((page.get_by_role("link", name="Watch the replay").get_attribute("href") or "") + "#tick=150")
    replay.locator("canvas").first.wait_for()
    replay.get_by_label("paths of the last five seconds").check()
    replay.evaluate("scrollTo(0, 0)")
    replay.wait_for_timeout(1500)
    _keep(replay, "replay")


def _phone(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("DistancePriority", red="scripted", limit_ticks=120)
    page = open_page(room["join_path"], room, **PHONE, color_scheme="dark")
    start(page, tap=True)
    wait_for(page, "game.entities().robots[1].held >= 0", 40)
    _keep(page, "game-phone")
    wait_for(page, "game.phase === 'series_over'", 60)
    page.locator(".deliveries").wait_for()
    _keep(page, "result-phone")
    page.get_by_role("button", name="Answer 10 questions").tap()
    page.locator("#after fieldset").first.wait_for()
    _keep(page, "questions-phone")


def _company(server: Server, open_page: OpenPage) -> None:
    """The invitation of a second person, and the editor."""
    room = server.make_room("LeftRight", red="link")
    page = open_page(room["join_path"], room)
    page.locator("#ready .qr").wait_for()
    page.wait_for_timeout(500)
    _keep(page, "invitation")
    editor = open_page("/editor")
    editor.locator("canvas").first.wait_for()
    editor.get_by_role("button", name="Play it").and_(editor.locator(":enabled")).wait_for()
    _keep(editor, "editor")


def _keep(page: Page, name: str) -> None:
    page.wait_for_timeout(300)
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    small = picture.quantize(COLOURS, dither=Image.Dither.NONE)
    path = FOLDER / f"{name}.png"
    small.save(path, "PNG", optimize=True)
    if path.stat().st_size > MOST_BYTES:
        raise SystemExit(f"{path} has {path.stat().st_size} bytes, more than {MOST_BYTES}")


if __name__ == "__main__":
    main()
