"""What is drawn in the arena can be seen and read: contrast of the real pixels, letters in CSS pixels."""

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.browser.pages import THEMES
from tests.browser.support import Server, start, wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]

LETTERS = """
window.__letters = [];
const fillText = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
  window.__letters.push([text, parseFloat(this.font.split(" ")[1]) * this.canvas.clientWidth / this.canvas.width]);
  return fillText.call(this, text, ...place);
};
"""
PIXEL = """([x, y]) => {
  const arena = document.querySelector("#arena");
  const at = (value) => Math.round(value / 2.4 * arena.width);
  const copy = new OffscreenCanvas(1, 1).getContext("2d");
  copy.drawImage(arena, at(x + 1.2), at(1.2 - y), 1, 1, 0, 0, 1, 1);
  return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
}"""


def luminance(colour: list[int]) -> float:
    """Relative luminance by WCAG 2."""
    parts = [value / 255 for value in colour]
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: list[int], other: list[int]) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def pixel(page: Page, x: float, y: float) -> list[int]:
    """The colour at a place in the arena."""
    colour: list[int] = page.evaluate(PIXEL, [x, y])
    return colour


@pytest.mark.parametrize("theme", THEMES)
def test_own_ring_and_items_stand_out_from_the_floor(server: Server, open_page: OpenPage, theme: str) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    page = open_page(room["join_path"], room, color_scheme=theme)
    start(page)
    floor = pixel(page, -1.0, 1.0)
    seen: dict[str, Any] = page.evaluate("window.__movingout.entities()")
    blue = seen["robots"][0]
    ring = pixel(page, blue["x"], blue["y"] + 0.12 + 0.02)
    body = pixel(page, blue["x"] - 0.05, blue["y"] - 0.05)
    assert contrast(ring, floor) >= 3
    assert contrast(body, floor) >= 3
    for item in seen["items"]:
        fill = pixel(page, item["x"] - 0.03, item["y"] - 0.03)
        assert contrast(fill, floor) >= 3, item["size"]


def test_letters_and_marks_have_at_least_twelve_pixels_on_a_phone(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    phone: dict[str, Any] = {"viewport": {"width": 375, "height": 553}, "has_touch": True, "is_mobile": True}
    page = open_page(room["join_path"], room, script=LETTERS, device_scale_factor=3, **phone)
    wait_for(page, "game.phase === 'lobby' && window.__letters.length > 8")
    letters: list[tuple[str, float]] = page.evaluate("window.__letters")
    assert {text for text, _ in letters if text} >= {"B", "R", "1–2"}
    assert min(size for text, size in letters if text) >= 12


PAINT_BOTH = """async () => {
  const { Painter } = await import("/static/view/painter.js");
  const { context2d, drawScene, startView } = await import("/static/view/render.js");
  const map = window.__movingout.map;
  const canvas = () => {
    const one = document.createElement("canvas");
    one.width = one.height = 700;
    return context2d(one, true);
  };
  const [parts, whole] = [canvas(), canvas()];
  const painter = new Painter(parts);
  const view = startView(map);
  let [worst, drawn] = [0, 0];
  for (let step = 0; step < 60; step += 1) {
    const driven = (body, angle) =>
      [1.15 * Math.sin(step / 9 + body), 1.15 * Math.cos(step / 7 + 2 * body), angle + step / 10];
    const poses = view.poses.map((pose, body) => (body < 3 ? driven(body, pose[2]) : pose));
    const held = step > 20 && step < 40 ? [0, step > 30 ? 0 : -1] : [-1, -1];
    const now = { poses, held, delivered: view.delivered.map((_, item) => step > 45 && item === 0) };
    const options = { rounded: true, own: [0], pulse: (step % 10) / 10, reach: [step % 3 ? -1 : 1, -1],
      intents: [{ x: 1, y: 0.5 }, null], misses: [step % 5 ? 0 : 1, 0] };
    const fill = parts.drawImage;
    parts.drawImage = function (...how) { drawn += how.length > 5 ? 1 : 0; return fill.apply(this, how); };
    painter.paint(map, now, options, false);
    delete parts.drawImage;
    drawScene(whole, map, now, options);
    const [one, other] = [parts, whole].map((ctx) => ctx.getImageData(0, 0, 700, 700).data);
    let off = 0;
    for (let at = 0; at < one.length; at += 1) off += Math.abs(one[at] - other[at]) > 64 ? 1 : 0;
    worst = Math.max(worst, off);
  }
  return [worst, drawn];
}"""


@pytest.mark.parametrize("map_name", ["AdaptiveAssist", "LeftRight"])
def test_drawing_only_what_changed_gives_the_same_picture(server: Server, open_page: OpenPage, map_name: str) -> None:
    page = open_page(server.make_room(map_name, red="idle")["watch_path"])
    wait_for(page, "game.map")
    worst, drawn = page.evaluate(PAINT_BOTH)
    assert drawn > 60, "most pictures are drawn in parts"
    assert worst == 0, "smooth edges may differ by a shade; what is missing or left over differs by more"


def test_a_page_that_draws_slowly_goes_on_with_a_canvas_in_memory(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("AdaptiveAssist", red="idle")
    slow = "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 40);"
    page = open_page(room["join_path"], room, script=slow)
    page.wait_for_function(
        "() => document.querySelector('#arena').getContext('2d').getContextAttributes().willReadFrequently"
    )
    start(page)
    assert contrast(pixel(page, 0.0, 0.1), [0, 0, 0]) > 10, "the goal is drawn"
    assert page.locator("#arena").get_attribute("aria-label").startswith("The arena")  # type: ignore[union-attr]
    page.wait_for_function("() => document.querySelector('#arena').getAttribute('aria-label').includes('0 of 6')")
