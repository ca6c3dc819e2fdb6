"""The 3D viewer in a real Chromium that draws by software: long, because its shaders are."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import viser
from PIL import Image
from playwright.sync_api import Page, Playwright, ViewportSize

from movingout.recordings.viewer.recording_cache import RecordingCache
from movingout.recordings.viewer.viewer import Viewer
from movingout.server.cli import main
from tests.browser.chromium import Chromium
from tests.recordings.viewer.support import put, recorded

# WebGL without a graphics processor; the game's own tests run faster without these.
FLAGS = (
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
WINDOW: ViewportSize = {"width": 800, "height": 500}
LOW: ViewportSize = {"width": 700, "height": 120}
PATIENCE_MS = 240_000.0
PATIENCE_LOOKS = 90
BAR = 40  # pixels, half the height of the page's own play bar at most: it is blue as well

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def drawing_chromium(playwright: Playwright) -> Iterator[Chromium]:
    """A second browser, with WebGL."""
    drawing = Chromium(playwright, FLAGS)
    yield drawing
    drawing.close()


@pytest.fixture
def open_window(drawing_chromium: Chromium) -> Iterator[Callable[..., Page]]:
    """Opens small windows, which are closed after the test: each one left open slows the next test down."""
    with drawing_chromium.for_a_test() as chromium:

        def make(**options: Any) -> Page:
            page = chromium.new_context(**{"viewport": WINDOW, **options}).new_page()
            page.set_default_timeout(PATIENCE_MS)
            return page

        yield make


def picture(client: viser.ClientHandle) -> npt.NDArray[np.int64]:
    return client.get_render(height=240, width=320).astype(np.int64)


def blue_pixels(image: npt.NDArray[np.int64]) -> int:
    red, green, blue = (image[..., channel] for channel in range(3))
    return int(((blue > red + 60) & (blue > green + 15)).sum())


def test_the_timeline_moves_what_a_visitor_sees(tmp_path: Path, open_window: Callable[..., Page]) -> None:
    with Viewer(RecordingCache([recorded(tmp_path, ticks=60)])) as viewer:
        page = open_window()
        page.goto(viewer.url)
        page.get_by_text("Playback").wait_for()
        ((_, client),) = viewer.server.get_clients().items()
        (panel,) = viewer.panels
        before = picture(client)
        put(panel.tick, 60)
        put(panel.trail, 0.0)
        after = picture(client)
        assert blue_pixels(before) > 20 and blue_pixels(after) > 20
        assert (np.abs(after - before).max(axis=-1) > 40).sum() > 50
        assert page.get_by_text("6.0 s · 0 of 4 delivered").is_visible()


def test_two_visitors_move_their_own_timelines(tmp_path: Path, open_window: Callable[..., Page]) -> None:
    with Viewer(RecordingCache([recorded(tmp_path)])) as viewer:
        for _ in range(2):
            page = open_window(viewport=LOW)  # few pixels: two of them draw by software at once
            page.goto(viewer.url)
            page.get_by_text("Playback").wait_for()
        one, other = viewer.panels
        put(one.tick, 12)
        put(other.play, True)
        viewer.advance(0.5)
        assert (one.tick.value, other.tick.value) == (12, 5)


def test_a_page_written_for_a_colleague_opens_from_a_file_and_plays(
    tmp_path: Path, open_window: Callable[..., Page], pictures: Path
) -> None:
    out = tmp_path / "page.html"
    assert main(["recordings", "view", str(recorded(tmp_path, ticks=60)), "--html", str(out)]) == 0
    page = open_window(offline=True)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(out.as_uri())
    shot = pictures / "viewer-page.png"
    seen = 0
    for _ in range(PATIENCE_LOOKS):  # it fades in, slowly where software draws
        page.screenshot(path=shot)
        above_the_bar = np.asarray(Image.open(shot).convert("RGB"), dtype=np.int64)[: -2 * BAR]
        seen = blue_pixels(above_the_bar)
        if seen > 20:
            break
        page.wait_for_timeout(1000.0)
    assert seen > 20, "no blue robot came into sight"
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
