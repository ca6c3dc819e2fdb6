"""The annotator's page: findings are watched and judged by keys, buttons and fingers, in both languages."""

import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Locator, Page, Route, expect

from movingout.recordings.annotation.verdicts import VERDICTS_NAME, verdicts_of
from tests.browser.pages import admin_token, overflow, violations
from tests.browser.support import DESKTOP, PHONE, Server, running_server
from tests.recordings.annotation.support import waiting_alone

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
GROUND = "button => getComputedStyle(button).backgroundColor"
EPISODES = ("annotated-1", "annotated-2")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server of its own: recordings that other tests leave behind may have findings, too."""
    with running_server(tmp_path_factory.mktemp("annotated")) as running:
        yield running


@pytest.fixture
def folder(server: Server) -> Iterator[Path]:
    """Two recordings with a finding each."""
    place = server.data / "recordings"
    paths = [waiting_alone(place, name) for name in EPISODES]
    yield place
    for path in (*paths, place / VERDICTS_NAME):
        path.unlink(missing_ok=True)


def annotating(open_page: OpenPage, server: Server, name: str = "Ada", **options: object) -> Page:
    """The page as Ada, or whoever, sees it."""
    script = f"sessionStorage.setItem('movingout.admin', {json.dumps(admin_token(server))});"
    page = open_page("/annotate", script=script, **options)
    page.locator("#annotator").fill(name)
    page.keyboard.press("Enter")
    expect(page.locator(".annotate-span")).to_be_attached(timeout=30_000)
    return page


def left_while_saving(page: Page) -> Route:
    """Answers the first finding and opens the last; the verdict of the first is still on its way."""
    held: list[Route] = []
    page.route("**/api/findings/verdicts", lambda route: held.append(route))
    page.keyboard.press("1")
    until(page, lambda: bool(held))  # which the route hears of later than the page
    page.locator(".annotate-finding").last.click()
    return held[0]


HELD_VERDICT = """() => {
  const real = window.fetch;
  window.fetch = (place, how) => !String(place).includes("verdicts") ? real(place, how)
    : new Promise((_, fail) => { window.lose = () => fail(new TypeError("no connection")); });
}"""
"""The next verdict stays on its way until it is lost, by `window.lose()`."""


def judged(folder: Path) -> list[str]:
    return [line.verdict for line in verdicts_of(folder)]


def test_all_findings_are_judged_with_the_keyboard_and_an_answer_can_be_changed(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    question = page.locator("#question")
    expect(question).to_have_text("Red needs help with the large rectangle. Does Blue fail to come?")
    for done in range(2):
        expect(page.locator("#progress")).to_have_text(f"{done} of 2 judged")
        expect(page.locator(".annotate-span")).to_be_attached(timeout=30_000)
        page.keyboard.press("1")
    expect(page.locator("#problem")).to_have_text("You have judged all of these. Thank you!")
    assert judged(folder) == ["confirmed"] * 2
    row = page.locator(".annotate-finding").first
    row.click()
    expect(page.locator("#confirmed")).to_have_attribute("aria-pressed", "true")
    page.locator("#note").fill("321 r")  # typed, and no key of the page
    page.locator("#rejected").click()
    expect(row).to_contain_text("No")
    page.reload()
    expect(page.locator("#progress")).to_have_text("2 of 2 judged", timeout=30_000)


@pytest.mark.parametrize("key", ["1", "Enter"])
def test_a_key_held_down_and_a_double_click_judge_one_finding(
    open_page: OpenPage, server: Server, folder: Path, key: str
) -> None:
    page = annotating(open_page, server)
    yes = page.locator("#confirmed")
    yes.focus()
    page.keyboard.down(key)
    expect(page.locator("#progress")).to_have_text("1 of 2 judged")
    expect(page.locator(".annotate-span")).to_be_attached(timeout=30_000)
    page.keyboard.down(key)  # repeated, by now about the other finding
    page.keyboard.up(key)
    yes.dispatch_event("click", {"detail": 2})
    page.keyboard.press("2")
    expect(page.locator("#progress")).to_have_text("2 of 2 judged")
    assert judged(folder) == ["confirmed", "rejected"]


def test_a_finding_is_judged_once_it_is_shown_and_where_it_cannot_be_only_as_unclear(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    held: list[Route] = []
    page.route("**/poses", lambda route: held.append(route))
    page.keyboard.press("1")
    expect(page.locator("#progress")).to_have_text("1 of 2 judged")
    page.keyboard.press("1")  # nothing of it has been seen
    until(page, lambda: bool(held))
    held[0].fulfill(body=b"")
    expect(page.locator("#problem")).to_contain_text("This recording has 0 pictures")
    expect(page.locator("#confirmed")).to_be_disabled()
    page.keyboard.press("2")
    page.keyboard.press("3")
    expect(page.locator("#progress")).to_have_text("2 of 2 judged")
    assert judged(folder) == ["confirmed", "unsure"]


def test_who_chooses_another_finding_while_a_verdict_is_saved_stays_there(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    verdict = left_while_saving(page)
    page.locator("#note").fill("seen from afar")
    verdict.continue_()
    expect(page.locator("#progress")).to_have_text("1 of 2 judged")
    expect(page.locator(".annotate-finding").last).to_have_attribute("aria-current", "true")
    expect(page.locator("#note")).to_have_value("seen from afar")
    assert judged(folder) == ["confirmed"]


def test_a_note_is_not_lost_with_a_verdict_that_fails_after_another_finding_was_chosen(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    page.evaluate(HELD_VERDICT)
    page.locator("#note").fill("lets go too late")
    page.locator("#confirmed").click()
    page.locator(".annotate-finding").last.click()
    page.evaluate("window.lose()")
    expect(page.locator("#problem")).to_contain_text("was not saved")
    expect(page.locator("#note")).to_have_value("")
    page.locator(".annotate-finding").first.click()
    expect(page.locator("#note")).to_have_value("lets go too late")
    expect(page.locator("#confirmed")).to_have_attribute("aria-pressed", "false")
    assert judged(folder) == []


def test_who_comes_back_while_a_verdict_is_saved_goes_on_with_the_note(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    verdict = left_while_saving(page)
    page.locator(".annotate-finding").first.click()
    page.locator("#note").fill("on second thought")
    verdict.continue_()
    expect(page.locator("#confirmed")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#note")).to_have_value("on second thought")
    expect(page.locator(".annotate-finding").first).to_have_attribute("aria-current", "true")
    assert judged(folder) == ["confirmed"]


def test_the_excerpt_plays_around_the_finding_and_can_be_watched_again(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server)
    page.get_by_label("Speed").select_option("8")
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=30_000)  # at its end it stands still
    stopped = page.evaluate("window.__movingout.transport.tick")
    page.keyboard.press("r")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    page.keyboard.press("Space")
    assert page.evaluate("window.__movingout.transport.tick") < stopped


def short_findings(route: Route) -> None:
    """Findings that end two seconds after the start: their excerpt ends at tick 50."""
    answer = route.fetch().json()
    route.fulfill(json={**answer, "findings": [{**one, "end": 20} for one in answer["findings"]]})


def test_who_moves_behind_the_excerpt_in_a_pause_plays_on_at_the_first_press(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server, reduced_motion="reduce")
    page.route("**/api/findings", short_findings)
    page.reload()
    expect(page.locator(".annotate-span")).to_be_attached(timeout=30_000)
    for _ in range(6):
        page.keyboard.press("Shift+ArrowRight")  # a second
    page.keyboard.press("Space")
    page.wait_for_function("() => window.__movingout.transport.tick > 65")


def test_less_motion_means_that_nothing_plays_by_itself(open_page: OpenPage, server: Server, folder: Path) -> None:
    page = annotating(open_page, server, reduced_motion="reduce")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    assert page.evaluate("window.__movingout.transport.player.playing") is False


def test_a_phone_shows_question_and_buttons_below_the_arena_in_german(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server, viewport=PHONE, has_touch=True, locale="de-DE")
    expect(page.get_by_role("heading", name="Fehlverhalten", level=1)).to_be_visible()
    expect(page.locator("#question")).to_have_text("Rot braucht Hilfe: Rechteck (groß). Kommt Blau nicht zu Hilfe?")
    expect(page.get_by_role("button", name="Unklar")).to_be_in_viewport(ratio=1)
    assert overflow(page) <= 0
    page.locator("#confirmed").tap()
    expect(page.locator("#progress")).to_have_text("1 von 2 beurteilt")


def test_in_forced_colours_the_time_line_the_arrow_of_a_list_and_the_answer_can_be_seen(
    open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server, forced_colors="active", reduced_motion="reduce")
    speed = page.get_by_label("Speed")
    until(page, lambda: bool(drawn(page.locator("#line"))[:, 4:-4].any(axis=0).all()))
    until(page, lambda: bool(drawn(speed)[8:-8, -32:-8].any()))
    yes = page.locator("#confirmed")
    page.keyboard.press("1")
    expect(page.locator("#progress")).to_have_text("1 of 2 judged")
    first = page.locator(".annotate-finding").first
    first.click()
    expect(yes).to_have_attribute("aria-pressed", "true")
    grounds = [one.evaluate(GROUND) for one in (yes, page.locator("#rejected"))]
    assert grounds[0] != grounds[1]


def until(page: Page, seen: Callable[[], bool]) -> None:
    """A busy machine draws late."""
    for _ in range(50):
        if seen():
            return
        page.wait_for_timeout(100)
    assert seen()


def drawn(place: Locator) -> np.ndarray:
    """(height, width) where it differs from its own middle of the upper edge, which is empty."""
    seen = np.asarray(Image.open(io.BytesIO(place.screenshot())).convert("L")).astype(int)
    differs: np.ndarray = np.abs(seen - seen[3, seen.shape[1] // 2]) > 5
    return differs


def test_a_screen_reader_hears_whose_failure_is_meant(open_page: OpenPage, server: Server, folder: Path) -> None:
    page = annotating(open_page, server)
    expect(page.get_by_role("button", name="Blue Does not come to help").first).to_be_visible()


@pytest.mark.parametrize("name", ["प्रिया", "O’Brien"])
def test_a_name_may_be_written_with_vowel_signs_or_an_apostrophe(
    name: str, open_page: OpenPage, server: Server, folder: Path
) -> None:
    page = annotating(open_page, server, name=name)
    page.keyboard.press("1")
    expect(page.locator("#progress")).to_have_text("1 of 2 judged")


def test_what_is_asked_before_says_what_for(open_page: OpenPage, server: Server, folder: Path) -> None:
    page = open_page("/annotate")
    expect(page.get_by_role("heading", level=1, name="Failure cases")).to_be_visible()
    form = page.locator(".token-form").bounding_box()
    assert form is not None and form["width"] <= 440
    assert violations(page) == []
    page.get_by_label("Admin token").fill(admin_token(server))
    page.keyboard.press("Enter")
    expect(page.get_by_label("Your name as annotator")).to_be_focused()
    expect(page.get_by_text("Rules found these moments.").first).to_be_visible()
    assert violations(page) == []


@pytest.mark.parametrize("locale", ["en-GB", "de-DE"])
@pytest.mark.parametrize("viewport", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_page_is_accessible_before_and_after_all_are_judged(
    open_page: OpenPage, server: Server, folder: Path, viewport: dict[str, int], locale: str
) -> None:
    page = annotating(open_page, server, viewport=viewport, locale=locale)
    assert overflow(page) <= 0
    assert violations(page) == []
    for done in range(2):
        expect(page.locator("#progress")).to_contain_text(f"{done} ")
        expect(page.locator(".annotate-span")).to_be_attached(timeout=30_000)
        page.keyboard.press("1")
    expect(page.locator("#problem .notice")).to_be_visible()
    assert violations(page) == []
