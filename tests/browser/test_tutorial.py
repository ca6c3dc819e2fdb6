"""The tutorial in the browser: finished by touch on a small phone by somebody who only knows what is on the screen."""

import math
import time
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import CDPSession, Page, expect

from movingout.recordings.storage.listing import read_summary, recording_paths
from tests.browser.conftest import OpenPage
from tests.browser.support import Server, robot, wait_for

SIGHT = (Path(__file__).parent / "sight.js").read_text()
PHONE: dict[str, Any] = {"viewport": {"width": 375, "height": 553}, "has_touch": True, "is_mobile": True}
NEAR = 0.13  # of the arena's side: own robot to what glows, when a grab is worth a try
THUMB_PX = 40
PLAY_S = 150.0


class Newcomer:
    """Looks at the page and uses two thumbs."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.touch: CDPSession = page.context.new_cdp_session(page)
        self.stick, self.grab, self.backward = (
            _centre(page, part) for part in ("#stick", "#touch-grab", "#touch-backward")
        )
        self._tapped_at = 0.0
        self._thumbs: tuple[int, ...] = ()

    def look(self) -> dict[str, Any]:
        seen: dict[str, Any] = self.page.evaluate("window.__sight()")
        return seen

    def play(self) -> list[str]:
        """Do what the words say until the tutorial is over; returns the words in their order."""
        heard: list[str] = []
        deadline = time.monotonic() + PLAY_S
        while time.monotonic() < deadline:
            seen = self.look()
            if seen["end"]:
                self.thumbs()
                return heard
            if seen["words"] not in heard[-1:]:
                heard.append(seen["words"])
            self.follow(seen)
            self.page.wait_for_timeout(60)
        raise AssertionError(f"not finished: {heard}, {seen}")

    def follow(self, seen: dict[str, Any]) -> None:
        words, me, glow, home = seen["words"], seen["me"], seen["glow"], seen["home"]
        if "backward" in words:
            self.thumbs((0.0, 1.0), backward=True)
        elif "Grab" in words and glow["count"] > 20:
            dx, dy = glow["x"] - me["x"], glow["y"] - me["y"]
            self.thumbs((dx, dy))
            if math.hypot(dx, dy) < NEAR + (0.06 if " 2 " in words else 0.0):
                self.tap_grab()
        elif "green" in words and me["y"] < home["bottom"]:
            self.thumbs()
            self.tap_grab()
        elif "green" in words or "home" in words:
            self.thumbs((0.0, -1.0))
        elif glow["count"] > 20:
            self.thumbs((glow["x"] - me["x"], glow["y"] - me["y"]))
        else:
            self.thumbs()

    def thumbs(self, direction: tuple[float, float] = (0.0, 0.0), backward: bool = False) -> None:
        """Where the left thumb pushes (right, down), and whether the right one holds the backward button."""
        length = math.hypot(*direction)
        points = []
        if length > 0:
            x, y = (self.stick[axis] + THUMB_PX * direction[index] / length for index, axis in enumerate("xy"))
            points.append({"id": 1, "x": x, "y": y})
        if backward:
            points.append({"id": 2, **self.backward})
        wanted = tuple(int(point["id"]) for point in points)
        if wanted != self._thumbs:
            if self._thumbs:
                self._send("touchEnd")
            for count in range(1, len(wanted) + 1):
                first = [{"id": 1, **self.stick}, *points[1:]] if length > 0 else points
                self._send("touchStart", *first[:count])
            self._thumbs = wanted
        if points:
            self._send("touchMove", *points)

    def tap_grab(self) -> None:
        if time.monotonic() - self._tapped_at < 0.7:
            return
        self._tapped_at = time.monotonic()
        self.thumbs()
        self._send("touchStart", {"id": 3, **self.grab})
        self._send("touchEnd")
        self.page.wait_for_timeout(250)

    def _send(self, kind: str, *points: dict[str, Any]) -> None:
        self.touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})


def _centre(page: Page, part: str) -> dict[str, float]:
    box = page.locator(part).bounding_box()
    assert box is not None
    return {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}


def test_a_newcomer_finishes_the_tutorial_by_touch_on_a_small_phone(
    server: Server, open_page: OpenPage, pictures: Path
) -> None:
    page = open_page("/", script=SIGHT, **PHONE)
    page.get_by_role("button", name="Learn in 1 minute").tap()
    page.wait_for_url("**/play/*")
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator(".tutorial-words")).to_contain_text("Drive into the ring")
    page.touchscreen.tap(20, 540)
    page.screenshot(path=pictures / "tutorial-375x553.png")
    heard = Newcomer(page).play()
    expect(page.get_by_role("heading", name="You are ready to play")).to_be_visible()
    page.screenshot(path=pictures / "tutorial-375x553-end.png")
    starts = ["Drive into", "Drive up to", "Bring it", "Drive backward", "A 2 needs", "Well done"]
    assert [words.startswith(start) for words, start in zip(heard, starts, strict=True)] == [True] * 6, heard
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight"), "nothing scrolls"
    page.get_by_role("button", name="Once more").tap()
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator(".tutorial-words")).to_contain_text("Drive into the ring")


def test_the_words_name_the_keys_and_skip_is_recorded(server: Server, open_page: OpenPage, pictures: Path) -> None:
    room = server.post("/api/rooms", {"tutorial": True})
    page = open_page(room["join_path"], room, locale="de-DE")
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator(".tutorial-words")).to_contain_text("Fahren Sie in den Ring: W A S D")
    expect(page.locator("#tutorial")).to_contain_text("Schritt 1 von 5")
    page.screenshot(path=pictures / "tutorial-desktop-de.png")
    page.keyboard.down("KeyW")
    expect(page.locator("#tutorial")).to_contain_text("Schritt 2 von 5")
    page.keyboard.up("KeyW")
    page.get_by_role("button", name="Überspringen").click()
    page.wait_for_url(server.url + "/")
    deadline = time.monotonic() + 20
    while not any(
        summary.source == "tutorial" and summary.outcome == "stopped"
        for summary in map(read_summary, recording_paths(server.data / "recordings"))
    ):
        assert time.monotonic() < deadline
        time.sleep(0.2)


@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_what_a_grab_would_take_is_outlined_and_a_miss_is_seen(
    server: Server, open_page: OpenPage, pictures: Path, motion: str
) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room, reduced_motion=motion)
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Space")  # nothing is in reach yet
    wait_for(page, "game.cues.missed > 0")
    assert page.evaluate("window.__movingout.cues.reach[0]") == -1
    page.keyboard.down("KeyW")
    page.keyboard.down("KeyD")
    wait_for(page, "game.cues.reach[0] >= 0", timeout_s=8)
    found = page.evaluate("window.__movingout.cues.reach[0]")
    page.keyboard.press("Space")
    page.keyboard.up("KeyW")
    page.keyboard.up("KeyD")
    wait_for(page, "game.entities().robots[0].held >= 0")
    assert robot(page, 0)["held"] == found
    page.screenshot(path=pictures / f"cue-held-{motion}.png")


def test_sounds_play_after_a_gesture_can_be_muted_and_stay_muted(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    page = open_page(room["join_path"], room)
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Space")
    wait_for(page, "game.sounds.played.miss === 1")
    page.get_by_role("button", name="Sound on").click()
    page.keyboard.press("Space")
    wait_for(page, "game.cues.missed === 2")
    assert page.evaluate("window.__movingout.sounds.played.miss") == 1
    page.reload()
    expect(page.get_by_role("button", name="Sound off")).to_be_visible()


def test_a_sound_that_cannot_play_breaks_nothing(server: Server, open_page: OpenPage) -> None:
    room = server.practice()
    broken = "window.AudioContext = class { constructor() { throw new Error('no device'); } };"
    page = open_page(room["join_path"], room, script=broken)
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Space")
    wait_for(page, "game.cues.missed === 1 && game.sounds.played.miss === 0")
