"""What the tests of the pages beside the game share: axe, the admin's token, pages that may complain."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from playwright.sync_api import Browser, Page, Request, expect

from tests.browser.chromium import close
from tests.browser.support import DESKTOP, Server
from tests.support import ROOT

RUN_AXE = "async (only) => (await axe.run(document, {resultTypes: ['violations'], ...only})).violations"
COLOUR_RULES = {"runOnly": ["color-contrast", "link-in-text-block"]}
AXE = ROOT / "node_modules" / "axe-core" / "axe.min.js"
THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")


def violations(page: Page) -> list[str]:
    """What axe finds wrong on the page as it stands, in both themes, one line each; and whether it is styled at all."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE.read_text(encoding="utf-8") + "\n;0")
    found, grounds = [], set[str]()
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        only = COLOUR_RULES if grounds else {}  # a theme changes colours and nothing else
        grounds.add(page.evaluate("getComputedStyle(document.body).backgroundColor"))
        rules: list[dict[str, Any]] = page.evaluate(RUN_AXE, only)
        found += [f"{theme}, {rule['id']}: {node['html'][:120]}" for rule in rules for node in rule["nodes"]]
    if len(grounds) < len(THEMES):
        found.append(f"{page.url} has the same ground in both themes: its style is missing")
    return found


def sent_body(request: Request) -> dict[str, Any]:
    """The JSON that a page sent."""
    body: dict[str, Any] | None = request.post_data_json
    assert body is not None
    return body


def overflow(page: Page) -> int:
    """By how many pixels the page is wider than its window."""
    pixels: int = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    return pixels


def heading(page: Page, text: str) -> None:
    """The page is there that has this title."""
    expect(page.get_by_role("heading", name=text, level=1)).to_be_visible()


def press(page: Page, *keys: str) -> None:
    for key in keys:
        page.keyboard.press(key)


def admin_token(server: Server) -> str:
    """The token in the file that the server printed."""
    match = re.search(r"Admin token\s+in (.+)", server.log.read_text(encoding="utf-8"))
    assert match is not None, "the server printed no admin token"
    return Path(match.group(1)).read_text(encoding="ascii").strip()


@contextmanager
def complaining_page(browser: Browser, server: Server, path: str, **options: Any) -> Iterator[Page]:
    """A page on which the browser itself may report failed requests, because the test makes them fail."""
    context = browser.new_context(base_url=server.url, **{"viewport": DESKTOP, **options})
    try:
        page = context.new_page()
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        if path:
            page.goto(path)
        yield page
        assert errors == []
    finally:
        close(context)
