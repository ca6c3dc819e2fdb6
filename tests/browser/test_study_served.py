"""A whole study at a real server in real browsers: people with agents, people with people, the experimenter beside."""

import csv
import io
from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from movingout.server.study_bots.data_check import read_stored
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from movingout.study.store.tables import notes
from tests.browser.pages import overflow, violations
from tests.browser.study_participant import SCREEN, KeyboardParticipant
from tests.browser.study_served import StudyServer, served_study
from tests.browser.support import DESKTOP, PHONE, wait_for
from tests.server.study_bots.support import agents_text, pairs_text


def dashboard(study: StudyServer, **options: object) -> Page:
    page = study.page("/experimenter", **options)
    page.get_by_label("Admin token").fill(study.token)
    page.keyboard.press("Enter")
    expect(page.locator("#content")).to_be_visible()
    return page


def row(page: Page, number: int) -> Locator:
    """Of the participant who came as number so and so."""
    return page.locator("#participants tr[data-pid]").nth(number)


def act(page: Page, one: Locator, label: str, reason: str = "") -> None:
    one.get_by_role("button", name="Actions for").click()
    page.get_by_role("dialog").get_by_role("button", name=label).click()
    if reason:
        page.locator("#reason").fill(reason)
        page.get_by_role("dialog").get_by_role("button", name=label).click()
    expect(page.get_by_role("dialog")).to_have_count(0)


def until(page: Page, kind: str) -> None:
    page.wait_for_selector(f"{SCREEN}[data-kind={kind}] h1")


@pytest.mark.slow
def test_a_participant_with_agents_from_the_link_to_the_code_over_reloads_and_a_killed_server(
    browser: Browser, tmp_path: Path, pictures: Path
) -> None:
    with served_study(tmp_path, agents_text(ticks=20), browser) as study:
        page = study.page("/?PROLIFIC_PID=person-1")
        looked: set[str] = set()

        def look(kind: str) -> None:
            """Each screen once: accessible, on a phone, the same after a reload; at the break the server dies."""
            if kind in looked or page.locator(SCREEN).count() == 0:  # the game page has tests of its own
                return
            looked.add(kind)
            before = page.locator(f"{SCREEN} h1").inner_text()
            if kind == "break":
                study.kill()
                study.start()
            page.reload()
            until(page, kind)
            expect(page.locator(f"{SCREEN} h1")).to_have_text(before)
            assert violations(page) == [], kind
            page.emulate_media(color_scheme="light")
            page.screenshot(path=pictures / f"served-{kind}.png", full_page=True)
            page.set_viewport_size(PHONE)  # type: ignore[arg-type]
            assert overflow(page) == 0, kind
            page.set_viewport_size(DESKTOP)  # type: ignore[arg-type]

        person = KeyboardParticipant(page, look)
        person.walk()
        blocks = ["round", "break", "round", "questionnaire"] * 2
        assert person.seen == [
            *("consent", "form", "input-check", "practice"), *blocks, *("questionnaire", "debrief", "code")
        ]  # fmt: skip
        assert study.third_parties() == set()
        assert study.complaints() == []
        shown = page.locator("#completion-code").inner_text()
        folder = StudyFolder(read_study(study.file), study.server.data)
        kept = read_stored(folder)
        (one,) = kept.participants.values()
        assert (one["outcome"], one["code"]) == ("done", shown.strip())
        assert [round_["outcome"] for round_ in kept.rounds] == ["time"] * 4
        assert len(kept.answers) == 7 + 2 * 10 + 6


@pytest.mark.slow
def test_a_pair_and_the_experimenter_who_pauses_restarts_and_kills_the_server(
    browser: Browser, tmp_path: Path, pictures: Path
) -> None:
    with served_study(tmp_path, pairs_text(ticks=60), browser) as study:
        people = [KeyboardParticipant(study.page(f"/study?PROLIFIC_PID=person-{number}")) for number in (1, 2)]
        experimenter = dashboard(study)
        people[0].walk(until="waiting")
        people[0].page.screenshot(path=pictures / "served-waiting.png", full_page=True)
        people[1].walk(until="practice")
        until(people[0].page, "practice")
        enter(people)
        for person in people:
            person.press("Enough practice")
        for person in people:
            until(person.page, "round")
        enter(people)
        experimenter.screenshot(path=pictures / "served-dashboard.png", full_page=True)
        pause_and_restart(experimenter, people, pictures)
        for person in people:
            until(person.page, "round")
        enter(people)
        wait_for(people[0].page, "game.tick > 15")
        study.kill()
        study.start()
        for person in people:
            person.page.wait_for_url("**/study", timeout=60_000)  # the round goes on, ends, and the page leads back
            person.walk(until="round")
        stop_with_deletion(people, pictures)
        bring_in_and_send_away(study, experimenter)
        pay(experimenter)
        assert study.third_parties() == set()
        assert study.complaints() == []
        assert_kept(study)


@pytest.mark.slow
def test_two_at_one_screen_answer_alone_and_play_together(browser: Browser, tmp_path: Path, pictures: Path) -> None:
    with served_study(tmp_path, pairs_text(ticks=20), browser) as study:
        page = study.page("/study")
        page.get_by_role("button", name="Begin").click()
        until(page, "consent")
        page.get_by_role("button", name="Add the second person").click()
        page.get_by_role("button", name="Begin").click()
        together = KeyboardParticipant(page)
        for number in (1, 2):
            expect(page.get_by_text(f"Person {number}: it is your turn")).to_be_visible()
            together.walk(until="form")
            together.fill_in()
        until(page, "input-check")
        for key in (
            "KeyW",
            "KeyA",
            "KeyS",
            "KeyD",
            "Space",
            "ShiftLeft",
            "ArrowUp",
            "ArrowLeft",
            "ArrowDown",
            "ArrowRight",
            "Enter",
            "ShiftRight",
        ):
            page.keyboard.press(key)
        together.press("Continue")
        until(page, "practice")
        enter([together])
        together.press("Enough practice")
        until(page, "round")
        enter([together])
        wait_for(page, "game.phase === 'playing'")
        assert page.evaluate("window.__movingout.seats") == [0, 1]
        page.screenshot(path=pictures / "served-two.png")
        page.wait_for_url("**/study", timeout=60_000)
        for number in (1, 2):
            expect(page.get_by_text(f"Person {number}: it is your turn")).to_be_visible()
            together.fill_in()
        until(page, "round")
        kept = read_stored(StudyFolder(read_study(study.file), study.server.data))
        assert {row["unit"] for row in kept.participants.values()} == {1}
        assert len(kept.answers) == 2 * (7 + 2)
        assert study.complaints() == []


def enter(people: list[KeyboardParticipant]) -> None:
    for person in people:
        person.press("I am ready")
    for person in people:
        person.page.wait_for_url("**/play/*")
    for person in people:
        wait_for(person.page, "game.phase === 'playing'")


def pause_and_restart(experimenter: Page, people: list[KeyboardParticipant], pictures: Path) -> None:
    """All stand still, go on, and begin the round again; a note is kept."""
    experimenter.get_by_role("button", name="Pause all").click()
    wait_for(people[0].page, "game.phase === 'paused'")
    people[0].page.screenshot(path=pictures / "served-paused.png")
    expect(experimenter.get_by_text("Everything is paused")).to_be_visible()
    experimenter.get_by_role("button", name="Resume all", exact=True).click()
    wait_for(people[0].page, "game.phase !== 'paused'")
    expect(row(experimenter, 0).get_by_role("link", name="Watch")).to_be_visible()
    act(experimenter, row(experimenter, 0), "Restart the round", "the cable fell out")
    experimenter.get_by_label("What happened").fill("A fire drill.")
    experimenter.get_by_role("button", name="Add a note").click()
    expect(experimenter.locator("#notes li")).to_have_count(2)
    assert violations(experimenter) == []


def stop_with_deletion(people: list[KeyboardParticipant], pictures: Path) -> None:
    """One asks for deletion; the other is told, and gets a code as well."""
    page, other = people[0].page, people[1].page
    page.get_by_role("button", name="Stop the study").click()
    page.get_by_role("button", name="Stop, delete my data").click()
    until(page, "code")
    until(other, "code")
    for name, one in (("withdrew", page), ("partner-left", other)):
        one.emulate_media(color_scheme="light")
        one.screenshot(path=pictures / f"served-{name}.png", full_page=True)


def bring_in_and_send_away(study: StudyServer, experimenter: Page) -> None:
    """The next participant comes by the link that the experimenter opens, and has to leave again."""
    experimenter.get_by_role("button", name="Open next participant").click()
    expect(experimenter.get_by_alt_text("QR code of the link")).to_be_visible()
    link = experimenter.locator(".next-link").inner_text()
    experimenter.get_by_role("button", name="Close").click()
    third = study.page(link.removeprefix(study.server.url))
    until(third, "consent")
    assert "code=" not in third.url
    staying = experimenter.locator("#participants tr[data-pid]:not([data-finished])")
    expect(staying).to_have_count(1)  # the dashboard hears of those who have left a moment later
    act(experimenter, staying, "End the study for them", "a wrong person")
    until(third, "code")


def pay(experimenter: Page) -> None:
    """Everybody who has a code is in the payments, by the id that they were recruited with."""
    with experimenter.expect_download() as download:
        experimenter.get_by_role("button", name="Download CSV").click()
    rows = list(csv.DictReader(io.StringIO(download.value.path().read_text(encoding="utf-8-sig"))))
    assert [(row["source"], row["id"], row["outcome"]) for row in rows[:2]] == [
        ("prolific", "person-1", "withdrew"),
        ("prolific", "person-2", "partner-left"),
    ]
    assert all(row["code"] and row["currency"] == "USD" for row in rows[:2])


def assert_kept(study: StudyServer) -> None:
    folder = StudyFolder(read_study(study.file), study.server.data)
    kept = read_stored(folder)
    people = [kept.participants[kept.pids[name]] for name in ("person-1", "person-2")]
    assert [one["outcome"] for one in people] == ["withdrew", "partner-left"]
    assert len({one["code"] for one in people}) == 2
    assert all(answer["pid"] != people[0]["pid"] for answer in kept.answers)
    with closing(folder.open_existing()) as store:
        assert "A fire drill." in [note["text"] for note in store.rows(notes)]
