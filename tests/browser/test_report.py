"""The report of a folder as a reader opens it: from a file, in both themes, on a phone."""

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from movingout.recordings import finalise
from movingout.server.cli import main
from tests.browser.pages import THEMES, overflow, violations
from tests.browser.support import DESKTOP, PHONE, complaints
from tests.recordings.support import record

pytestmark = pytest.mark.slow

PAPER = {"width": 716, "height": 1010}  # A4 with its usual margins


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pilot")
    for seed, name in enumerate(("FourCorners", "FourCorners", "HandOff")):
        finalise(record(folder, 200, map_name=name, episode_id=f"{name}-{seed}", seed=seed)[0])
    (folder / "broken.mcap").write_bytes(b"")
    out = folder / "report.html"
    assert main(["recordings", "report", str(folder), "-o", str(out), "--workers", "1"]) == 0
    return out


@pytest.mark.parametrize("theme", THEMES)
def test_the_report_is_accessible_from_a_file_without_the_network(browser: Browser, report: Path, theme: str) -> None:
    options: dict[str, Any] = {"viewport": DESKTOP, "color_scheme": theme, "offline": True}
    context = browser.new_context(**options)
    page = context.new_page()
    said = complaints(page)
    page.goto(report.as_uri())
    expect(page.get_by_role("heading", name="Results by map")).to_be_visible()
    expect(page.get_by_text("broken.mcap is empty")).to_be_visible()
    assert violations(page) == []
    assert said == []


def test_on_a_phone_nothing_sticks_out(browser: Browser, report: Path) -> None:
    options: dict[str, Any] = {"viewport": PHONE}
    context = browser.new_context(**options)
    page = context.new_page()
    page.goto(report.as_uri())
    assert overflow(page) == 0


def test_on_paper_no_column_is_cut_and_what_is_folded_is_shown(browser: Browser, report: Path) -> None:
    options: dict[str, Any] = {"viewport": PAPER}
    context = browser.new_context(**options)
    page = context.new_page()
    page.goto(report.as_uri())
    page.emulate_media(media="print")
    sideways = "(boxes) => boxes.filter((box) => box.scrollWidth > box.clientWidth).length"
    assert page.locator(".scroll").evaluate_all(sideways) == 0
    assert overflow(page) == 0
    page.locator("main").evaluate("(main) => main.insertAdjacentHTML('beforeend', '<details><p>folded</p></details>')")
    assert page.locator("details p").evaluate("(text) => text.checkVisibility({contentVisibilityAuto: true})")
