"""The tutorial in the browser: finished by touch on a small phone by somebody who only knows what is on the screen."""

import math
import time
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import CDPSession, Page, expect

from movingout.recordings.storage.index import list_recordings
from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.newcomer import SIGHT, Newcomer
from tests.browser.study_fake import FakeStudy
from tests.browser.support import Server, robot, wait_for

pytestmark = pytest.mark.slow

PHONE: dict[str, Any] = {"viewport": {"width": 375, "height": 553}, "has_touch": True, "is_mobile": True}
THUMB_PX = 40


class Thumbs(Newcomer):
    """A newcomer with a touch screen."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.touch: CDPSession = page.context.new_cdp_session(page)
        self.stick, self.grab_button, self.backward = (
            _centre(page, part) for part in ("#stick", "#touch-grab", "#touch-backward")
        )
        self._tapped_at = 0.0
        self._thumbs: tuple[int, ...] = ()

    def look(self) -> dict[str, Any]:
        seen: dict[str, Any] = self.page.evaluate("window.__sight()")
        return seen

    def wait(self, seconds: float) -> None:
        self.page.wait_for_timeout(1000 * seconds)

    def push(self, direction: tuple[float, float] = (0.0, 0.0), backward: bool = False) -> None:
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

    def grab(self) -> None:
        if time.monotonic() - self._tapped_at < 0.7:
            return
        self._tapped_at = time.monotonic()
        self.push()
        self._send("touchStart", {"id": 3, **self.grab_button})
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
    heard = Thumbs(page).play()
    expect(page.get_by_role("heading", name="You are ready to play")).to_be_visible()
    page.screenshot(path=pictures / "tutorial-375x553-end.png")
    starts = ["Drive into", "Drive up to", "Bring it", "Drive backward", "A 2 needs", "Well done"]
    assert [words.startswith(start) for words, start in zip(heard, starts, strict=True)] == [True] * 6, heard
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight"), "nothing scrolls"
    expect(page.locator(".overlay-end .panel")).to_be_in_viewport(ratio=1)
    expect(page.get_by_role("link", name="Play now")).to_have_attribute("href", "/#play")
    page.get_by_role("button", name="Once more").tap()
    wait_for(page, "game.phase === 'playing'")
    expect(page.locator(".tutorial-words")).to_contain_text("Drive into the ring")


@pytest.mark.parametrize("size", [(375, 553), (390, 664)], ids=str)
def test_a_newcomer_finishes_the_tutorial_of_a_study_by_touch(
    server: Server, open_page: OpenPage, pictures: Path, size: tuple[int, int]
) -> None:
    room = server.post("/api/rooms", {"tutorial": True})
    seat = {"id": room["room"], "token": room["tokens"][0], "seat": 0, "path": room["join_path"]}
    practice = fake.play(kind="practice", map_name="Simple", tutorial=True)
    study = FakeStudy.at(practice, {**practice, "state": "playing", "room": seat}, fake.play())
    window = {"viewport": {"width": size[0], "height": size[1]}, "has_touch": True, "is_mobile": True}
    page = open_page("/healthz", script=SIGHT, **window)
    study.open(page)
    page.get_by_role("button", name="I am ready").tap()
    page.wait_for_url("**/play/*")
    wait_for(page, "game.phase === 'playing'")
    page.touchscreen.tap(20, size[1] - 13)
    heard = Thumbs(page).play()
    assert heard[-1] == "Well done!"
    expect(page.locator(".overlay-end .panel")).to_be_in_viewport(ratio=1)
    expect(page.get_by_role("heading", name="You are ready to play")).to_be_visible()
    page.screenshot(path=pictures / f"tutorial-study-{size[0]}x{size[1]}-end.png")
    study.people["token-of-person-1"].next()
    page.get_by_role("button", name="Continue").tap()
    expect(page.get_by_role("heading", level=1, name="Hand Off")).to_be_visible()


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
        for summary in list_recordings(server.data / "recordings")[0]
    ):
        assert time.monotonic() < deadline
        time.sleep(0.2)


def test_on_the_narrowest_phone_skip_covers_no_words_in_german(server: Server, open_page: OpenPage) -> None:
    room = server.post("/api/rooms", {"tutorial": True})
    phone = {**PHONE, "viewport": {"width": 320, "height": 568}, "locale": "de-DE"}
    page = open_page(room["join_path"], room, **phone)
    skip = page.get_by_role("button", name="Überspringen")
    expect(skip).to_be_visible()
    left = skip.evaluate("button => button.getBoundingClientRect().left")
    ends = page.locator("#tutorial .row > *").evaluate_all("all => all.map((one) => one.getBoundingClientRect().right)")
    assert max(ends) <= left
    expect(page.locator("#tutorial")).to_contain_text("Schritt 1 von 5")  # for whoever hears the page


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
