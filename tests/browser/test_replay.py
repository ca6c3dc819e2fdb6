"""The replay of a recording: the recorded states, tick by tick, with keys, marks and deep links."""

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, Route, expect

from movingout.recordings import Episode, finalise, read_episode
from movingout.world.metrics import METRICS, EpisodeMetrics
from tests.browser.pages import admin_token, complaining_page, overflow, violations
from tests.browser.support import PHONE, Server
from tests.recordings.support import record

OpenPage = Callable[..., Page]

EPISODE = "replayed-in-the-browser"
TICKS = 42  # events at 5, 10, ... 40: the recorded driver "takes" an item each time


@pytest.fixture(scope="module")
def episode(server: Server, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Episode]:
    """A recording of random driving on Hand Off, among the server's own."""
    journal, _ = record(tmp_path_factory.mktemp("recorded"), ticks=TICKS, map_name="HandOff", episode_id=EPISODE)
    finished = finalise(journal)
    place = server.data / "recordings" / finished.name
    place.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(finished, place)
    yield read_episode(finished)
    Path(place).unlink()


def replay(page: Page) -> Page:
    expect(page.locator("#replay")).to_be_visible(timeout=30_000)  # the first one starts the process that reads
    return page


def poses(page: Page) -> list[list[float]]:
    shown: list[list[float]] = page.evaluate("window.__movingout.entities().poses")
    return shown


def at_tick(page: Page, tick: int) -> None:
    expect(page.locator("#tick")).to_have_text(f"tick {tick} of {TICKS}")


def test_every_tick_shows_the_recorded_state(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    for tick, state in enumerate(episode.states[:12]):
        at_tick(page, tick)
        recorded = np.concatenate([state.robot_poses, state.item_poses])
        off = np.array(poses(page)) - recorded
        off[:, 2] = (off[:, 2] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(off).max() < 1e-4  # the wire's int16
        page.keyboard.press("ArrowRight")


def test_the_corners_are_drawn_and_not_clipped(open_page: OpenPage, episode: Episode) -> None:
    """A round clip of the canvas makes each picture several times as dear in WebKit."""
    page = replay(open_page(f"/replay/{EPISODE}"))
    styles = "['.replay-arena', '#arena'].map((one) => getComputedStyle(document.querySelector(one)))"
    assert page.evaluate(f"{styles}.every((style) => style.borderRadius === '0px' && style.overflowX !== 'hidden')")
    corner, ground = page.evaluate("""() => {
      const [red, green, blue] = document.querySelector("#arena").getContext("2d").getImageData(0, 0, 1, 1).data;
      return [`rgb(${red}, ${green}, ${blue})`, getComputedStyle(document.body).backgroundColor];
    }""")
    assert corner == ground


def test_a_deep_link_opens_at_its_tick_and_moving_on_updates_the_address(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}#tick=17"))
    at_tick(page, 17)
    page.keyboard.press("ArrowLeft")
    at_tick(page, 16)
    expect(page).to_have_url(re.compile("#tick=16$"))


def test_keys_step_jump_and_change_the_speed(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    for key, tick in (
        (".", 5),
        (".", 10),
        (",", 5),
        ("Shift+ArrowRight", 15),
        ("End", TICKS),
        ("ArrowRight", TICKS),
        ("Home", 0),
        ("ArrowLeft", 0),
    ):
        page.keyboard.press(key)
        at_tick(page, tick)
    page.get_by_text("Keys", exact=True).focus()
    page.keyboard.press("Space")  # opens the list of keys and plays nothing
    expect(page.get_by_text("previous, next event")).to_be_visible()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    page.keyboard.press("+")
    expect(page.get_by_label("Speed")).to_have_value("2")
    for _ in range(5):
        page.keyboard.press("-")
    expect(page.get_by_label("Speed")).to_have_value("0.25")


def test_playing_moves_at_the_chosen_speed_and_stops_at_the_end(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    at_tick(page, TICKS)
    expect(page.get_by_role("button", name="Play")).to_be_visible()


def test_an_event_leads_to_its_tick_and_is_marked_from_then_on(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    rows = page.locator(".replay-event")
    expect(rows).to_have_count(len(episode.events))
    expect(page.locator("#marks .replay-mark")).to_have_count(len(episode.events))
    rows.nth(2).click()
    at_tick(page, episode.events[2].tick)
    expect(rows.nth(2)).to_have_attribute("aria-current", "true")
    page.keyboard.press("ArrowLeft")
    expect(rows.nth(1)).to_have_attribute("aria-current", "true")


def test_the_time_line_is_a_slider_with_words(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    slider = page.get_by_role("slider", name="Tick")
    slider.fill("31")
    at_tick(page, 31)
    expect(slider).to_have_attribute("aria-valuetext", "0:03.1 of 0:04.2")


def test_the_measures_have_curves_with_their_values_at_the_tick(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}#tick=30"))
    running = EpisodeMetrics(episode.header.map)
    running.update_episode(list(episode.states[:31]), episode.actions[:30])
    now = running.result()
    rows = page.locator(".replay-curve-row")
    expect(rows).to_have_count(len(METRICS))
    for row, metric in enumerate(METRICS):
        expect(rows.nth(row)).to_contain_text(metric.symbol)
    expect(rows.nth(2).locator(".replay-curve-value")).to_have_text(f"{now.wt_s:.1f} s")
    page.keyboard.press("Home")
    expect(rows.nth(2).locator(".replay-curve-value")).to_have_text("–")


def test_a_click_on_a_curve_leads_to_that_tick(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    curve = page.locator(".replay-curve").nth(1)
    box = curve.bounding_box()
    assert box is not None
    curve.click(position={"x": box["width"] / 2, "y": 10})
    at_tick(page, TICKS // 2)


def test_paths_and_what_agents_weighed_lie_over_the_arena_when_wanted(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}#tick=40"))
    plain = page.locator("#arena").screenshot()
    page.keyboard.press("t")
    expect(page.get_by_label("paths of the last five seconds")).to_be_checked()
    page.get_by_label("what agents consider").check()
    expect(page.locator("#weighed")).to_contain_text("Red compares")
    assert page.locator("#arena").screenshot() != plain
    page.keyboard.press("a")
    page.keyboard.press("t")
    expect(page.locator("#weighed")).to_be_empty()
    assert page.locator("#arena").screenshot() == plain


def test_the_replay_speaks_the_language_of_the_address(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}?lang=de#tick=3"))
    expect(page.get_by_label("Geschwindigkeit").locator("option").first).to_have_text("0,25×")
    expect(page.get_by_role("heading", name="Was geschah")).to_be_visible()
    expect(page.locator("#tick")).to_have_text(f"Tick 3 von {TICKS}")
    assert violations(page) == []


def test_the_recording_can_be_downloaded(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    with page.expect_download() as download:
        page.get_by_role("link", name="Download").click()
    assert download.value.suggested_filename == f"{EPISODE}.mcap"
    assert read_episode(Path(download.value.path()).rename(download.value.path().with_suffix(".mcap"))).complete


def test_a_person_plays_with_the_recording(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    page.get_by_role("button", name="Take blue").click()
    expect(page).to_have_url(re.compile("/play/"))
    expect(page.get_by_text("Recording of Computer partner").first).to_be_visible()
    expect(page.get_by_text("Hand Off").first).to_be_visible()


def test_the_replay_is_accessible_in_both_themes(open_page: OpenPage, episode: Episode) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    page.get_by_text("Keys", exact=True).click()
    page.keyboard.press("End")
    assert violations(page) == []


@pytest.mark.parametrize("window", [PHONE, {"width": 320, "height": 225}], ids=["phone", "zoom of 400 %"])
def test_in_a_small_window_the_replay_is_one_column_without_overflow(
    open_page: OpenPage, episode: Episode, window: dict[str, int]
) -> None:
    page = replay(open_page(f"/replay/{EPISODE}", viewport=window))
    assert overflow(page) == 0
    assert page.locator("#play").bounding_box()["width"] >= 44  # type: ignore[index]


@pytest.mark.parametrize(
    ("width", "height", "arena"),
    [(375, 553, 290), (360, 640, 320), (280, 653, 240), (740, 360, 320), (568, 320, 280), (768, 1024, 680)],
)
def test_arena_and_time_line_share_a_small_window(
    open_page: OpenPage, episode: Episode, width: int, height: int, arena: int
) -> None:
    phone = {"viewport": {"width": width, "height": height}, "is_mobile": True, "has_touch": True}
    page = replay(open_page(f"/replay/{EPISODE}?lang=de", **phone))
    boxes = [page.locator(part).bounding_box() for part in ("#arena", "#line", "#play", "#speed")]
    for box in boxes:
        assert box is not None
        assert box["x"] + box["width"] <= width
        assert box["y"] + box["height"] <= height, "nobody has to scroll between what is seen and what plays it"
    assert boxes[0]["width"] >= arena  # type: ignore[index]
    assert page.evaluate("Math.max(innerWidth, document.documentElement.scrollWidth)") == width


def test_players_are_led_to_the_start_page_and_the_experimenter_to_the_list(
    server: Server, open_page: OpenPage, episode: Episode
) -> None:
    page = replay(open_page(f"/replay/{EPISODE}"))
    expect(page.locator(".replay-head a")).to_have_attribute("href", "/")
    unlocked = f"sessionStorage.setItem('movingout.admin', {admin_token(server)!r})"
    page = replay(open_page(f"/replay/{EPISODE}", script=unlocked))
    expect(page.locator(".replay-head a")).to_have_attribute("href", "/recordings")


@pytest.mark.parametrize("name", ["nothing-here", pytest.param("%E0%A4%A", marks=pytest.mark.slow)])  # cut in a mail
def test_an_unknown_recording_says_so_and_leads_on(browser: Browser, server: Server, name: str) -> None:
    with complaining_page(browser, server, f"/replay/{name}") as page:
        expect(page.get_by_text("This recording does not exist")).to_be_visible()
        said, way_on = (
            page.locator("#ask .notice").bounding_box(),
            page.locator("#ask .button").first.bounding_box(),
        )
        assert said is not None and way_on is not None
        assert way_on["y"] - said["y"] - said["height"] >= 12, "the buttons stand clear of the message"
        expect(page.get_by_role("link", name="All recordings")).to_be_visible()
        page.get_by_role("link", name="To the start page").click()  # the list asks strangers for a token
        expect(page.get_by_role("heading", name="Moving Out Live", level=1)).to_be_visible()


def blinded(route: Route) -> None:
    """As a server that runs a study: recordings are for the experimenter alone."""
    if "authorization" in route.request.headers:
        return route.continue_()
    refusal = {"error": {"code": "wrong_token", "message": "The admin token is needed."}}
    return route.fulfill(status=401, json=refusal)


def test_where_recordings_are_for_the_experimenter_the_token_opens_and_saves_them(
    browser: Browser, server: Server, episode: Episode
) -> None:
    with complaining_page(browser, server, "") as page:
        page.route("**/api/recordings/**", blinded)
        page.goto(f"/replay/{EPISODE}")
        expect(page.get_by_role("heading", level=1, name="Replay")).to_be_visible()
        page.get_by_label("Admin token").fill(admin_token(server))
        expect(page.get_by_text("Loading the replay")).to_be_hidden()
        page.keyboard.press("Enter")
        replay(page)
        expect(page.get_by_text("Play with this recording")).to_be_hidden()
        with page.expect_download() as download:
            page.get_by_role("link", name="Download").click()
        assert download.value.suggested_filename == f"{EPISODE}.mcap"
        page.goto("/replay/nothing-here")
        expect(page.get_by_text("The admin token is needed.")).to_have_count(0)
        expect(page.get_by_text("This recording does not exist")).to_be_visible()
