"""Two people at one screen: each consents and answers alone, and both play together."""

from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.pages import heading, press, violations
from tests.browser.study_fake import FakePerson, FakeStudy
from tests.browser.support import Server, wait_for
from tests.browser.test_devices import PAD_STUB, set_pad

pytestmark = pytest.mark.slow


def test_where_the_second_declines_the_first_goes_on_alone_and_may_ask_somebody_else(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.waiting(), group=2, asks_code=False)
    study.coming = [FakePerson([fake.consent()])]
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    page.get_by_role("button", name="Begin").click()
    page.get_by_role("button", name="I do not agree").click()
    expect(page.get_by_role("button", name="Add the second person")).to_be_visible()
    expect(page.get_by_text("it is your turn")).to_have_count(0)
    page.reload()
    expect(page.get_by_role("button", name="Add the second person")).to_be_visible()


def test_two_at_one_screen_agree_one_after_the_other_and_play_together(
    open_page: OpenPage, server: Server, pictures: Path
) -> None:
    room = server.make_room("Simple", blue="here", red="here")
    seats = [
        {"id": room["room"], "token": token, "seat": seat, "path": room["join_path"]}
        for seat, token in enumerate(room["tokens"])
    ]
    ways = [
        [fake.consent(), fake.input_check(), fake.play(seat=seat, partner_letter=None),
         fake.play("playing", seat=seat, room=seats[seat])]
        for seat in (0, 1)
    ]  # fmt: skip
    study = FakeStudy.at(*ways[0], group=2, asks_code=False)
    study.coming = [FakePerson(ways[1])]
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    heading(page, "The second person")
    page.get_by_role("button", name="Begin").click()
    for number in (1, 2):
        expect(page.get_by_text(f"Person {number}: it is your turn")).to_be_visible()
        page.get_by_label("I am 18 or older.").check()
        page.get_by_role("button", name="I agree").click()
    expect(page.locator(".check-panel")).to_have_count(2)
    press(page, "KeyW", "KeyA", "KeyS", "KeyD", "Space", "ShiftLeft")
    expect(
        page.get_by_text("Person 2, please also try: up, left, down, right, Grab, and Drive backward.")
    ).to_be_visible()
    expect(page.get_by_text("Person 1, please")).to_have_count(0)
    press(page, "ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight", "Enter", "ShiftRight")
    expect(page.get_by_text("Everything works.")).to_be_visible()
    assert violations(page) == []
    page.emulate_media(color_scheme="light")
    page.screenshot(path=pictures / "study-two-check.png", full_page=True)
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_text("Person 2 is red")).to_be_visible()
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'playing'")
    assert page.evaluate("window.__movingout.seats") == [0, 1]
    expect(page.get_by_role("button", name="Change…")).to_be_visible()
    assert page.get_by_role("button", name="Swap sides").count() == 0, "the study says who plays which robot"
    assert study.sent("/arrive") == [
        {"parameters": {}, "language": "en", "known": ["token-of-person-1"], "beside": "token-of-person-1"}
    ]
    page.get_by_role("button", name="Pause or stop…").click()
    page.get_by_role("button", name="Stop the study").click()
    page.get_by_label("Person 2").check()
    page.get_by_role("button", name="Stop, keep my data").click()
    page.wait_for_url("**/study")
    assert study.sent("/stop") == [{"keep": True}]
    assert [person.steps[0]["kind"] for person in study.people.values()] == ["round", "code"]


def test_the_form_for_the_second_person_closes_where_a_partner_has_come_from_elsewhere(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.waiting(), fake.play(kind="practice", map_name="Simple"), group=2, asks_code=False)
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    heading(page, "The second person")
    study.people["token-of-person-1"].next()
    expect(page.get_by_role("button", name="I am ready")).to_be_visible()
    assert study.sent("/arrive") == []


def test_the_form_for_the_second_person_stays_through_a_pause(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.waiting(), fake.every_screen()["paused"], group=2)
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    page.get_by_label("Your code").fill("K7QX")
    with page.expect_response("**/api/study/view"):
        study.people["token-of-person-1"].next()
    page.wait_for_load_state("networkidle")
    expect(page.get_by_label("Your code")).to_have_value("K7QX")


@pytest.mark.parametrize("number", [1, 2])
def test_of_two_in_a_pause_only_who_has_consented_can_stop(open_page: OpenPage, number: int) -> None:
    study = FakeStudy.at(fake.every_screen()["paused"], group=2, asks_code=False)
    study.people["token-of-person-2"] = FakePerson([fake.every_screen()["paused"]])
    study.people[f"token-of-person-{3 - number}"].can_stop = False  # at the consent
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Stop").click()
    expect(page.get_by_role("radio")).to_have_count(0)
    page.get_by_role("button", name="Stop, keep my data").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    stopped = study.people[f"token-of-person-{number}"], study.people[f"token-of-person-{3 - number}"]
    assert [person.steps[0]["kind"] for person in stopped] == ["code", "paused"]


@pytest.mark.parametrize(("width", "height"), [(375, 553), pytest.param(320, 568, marks=pytest.mark.slow)])
def test_of_two_at_one_screen_each_one_s_controls_are_said_and_kept_as_theirs(
    open_page: OpenPage, pictures: Path, width: int, height: int
) -> None:
    study = FakeStudy.at(fake.consent(), fake.input_check(), fake.waiting(), group=2, asks_code=False)
    study.coming = [FakePerson([fake.consent(), fake.input_check(), fake.waiting()])]
    page = open_page("/healthz", script=PAD_STUB, viewport={"width": width, "height": height})
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    page.get_by_role("button", name="Begin").click()
    for number in (1, 2):
        expect(page.get_by_text(f"Person {number}: it is your turn")).to_be_visible()
        page.get_by_label("I am 18 or older.").check()
        page.get_by_role("button", name="I agree").click()
    set_pad(page, 0, -1)  # the first gamepad is blue's
    expect(page.get_by_text("Person 1, please also try: left, down, right, Grab, and Drive backward.")).to_be_visible()
    press(page, "ArrowUp", "ArrowLeft", "ArrowDown", "ArrowRight")
    expect(page.get_by_text("Person 2, please also try: Grab and Drive backward.")).to_be_visible()
    page.screenshot(path=pictures / f"study-two-todo-{width}.png", full_page=True)
    page.get_by_role("button", name="Does a control not work?").click()
    page.get_by_role("button", name="Continue without trying it").click()
    heading(page, "Waiting for a second person")
    sent = [(one["device"], one["untried"]) for one in study.sent("/next") if "device" in one]
    assert sent == [("gamepad", ["left", "down", "right", "grab", "backward"]), ("keyboard", ["grab", "backward"])]


@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize("other", ["here", "elsewhere"])
def test_where_one_of_two_opens_their_link_again_the_other_stays_at_the_screen(
    open_page: OpenPage, number: int, other: str
) -> None:
    people = [FakePerson([fake.consent(), fake.input_check()]) for _ in range(2)]
    if other == "elsewhere":
        people[2 - number].steps = [{"key": "elsewhere", "kind": "ended-elsewhere"}]
    study = FakeStudy(people={"kept-1": people[0], "kept-2": people[1]}, group=2, asks_code=False)
    study.coming = [people[number - 1]]
    page = open_page("/healthz")
    study.open(page, "?PROLIFIC_PID=5f00")
    page.wait_for_url("**/study")
    expect(page.get_by_text("it is your turn")).to_have_count(1 if other == "here" else 0)
    kept = page.evaluate(
        "[1, 2].map((person) => localStorage.getItem(`movingout-study-token${person > 1 ? '-2' : ''}`))"
    )
    new = "token-of-person-3"
    assert kept == (([new, "kept-2"] if number == 1 else ["kept-1", new]) if other == "here" else [new, None])


def test_what_somebody_has_set_is_kept_for_them_and_not_for_whoever_comes_next(open_page: OpenPage) -> None:
    first = FakePerson([fake.code(shared_code=False)])
    study = FakeStudy(people={"token-of-person-1": first}, coming=[first, FakePerson([fake.input_check()])])
    page = open_page("/healthz")
    page.evaluate(SET_BY_SOMEBODY)
    study.open(page, "?code=AB-1")
    heading(page, "Thank you")
    assert page.evaluate(KEPT) == {"mapping": True, "sound": "off", "pads": "[7]"}
    page.goto("/study?code=AB-2")
    heading(page, "Try your controls")
    expect(page.locator(".check-panel")).to_contain_text("W A S D")
    assert page.evaluate(KEPT) == {"mapping": False, "sound": None, "pads": None}


def test_who_comes_back_from_another_browser_finds_what_they_had_set(open_page: OpenPage) -> None:
    study = FakeStudy(coming=[FakePerson([fake.input_check()], was_here=True)])
    page = open_page("/healthz")
    page.evaluate(SET_BY_SOMEBODY)
    study.open(page, "?code=AB-1")
    heading(page, "Try your controls")
    assert page.evaluate(KEPT) == {"mapping": True, "sound": "off", "pads": "[7]"}


def test_a_second_person_begins_with_the_second_keys_that_everybody_has(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.waiting(), group=2, asks_code=False)
    study.coming = [FakePerson([fake.consent()])]
    page = open_page("/healthz")
    page.evaluate("""localStorage.setItem("movingout.mapping", '{"keys": [{"up": "KeyT"}, {"up": "KeyI"}]}')""")
    study.open(page)
    page.get_by_role("button", name="Add the second person").click()
    page.get_by_role("button", name="Begin").click()
    expect(page.get_by_role("button", name="I do not agree")).to_be_visible()
    assert page.evaluate("localStorage.getItem('movingout.mapping')") == '{"keys":[{"up":"KeyT"},{}]}'


SET_BY_SOMEBODY = """() => {
  localStorage.setItem("movingout.mapping", '{"keys": [{"up": "KeyT"}]}');
  localStorage.setItem("movingout-sound", "off");
  sessionStorage.setItem("movingout.pads.study", "[7]");
}"""
KEPT = """() => ({
  mapping: localStorage.getItem("movingout.mapping") !== null,
  sound: localStorage.getItem("movingout-sound"),
  pads: sessionStorage.getItem("movingout.pads.study"),
})"""
