"""Every screen of a study, one at a time: readable by everybody, by keyboard alone, after reloads."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from movingout.study.design.instruments import DEMOGRAPHICS, NASA_TLX
from movingout.study.questionnaire import PAPER
from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.pages import complaining_page, heading, overflow, press, violations
from tests.browser.study_fake import FakePerson, FakeStudy
from tests.browser.study_participant import KeyboardParticipant
from tests.browser.support import DESKTOP, PHONE, Server, wait_for


def resize(page: Page, size: dict[str, int]) -> None:
    page.set_viewport_size({"width": size["width"], "height": size["height"]})


@pytest.mark.slow
@pytest.mark.parametrize("language", ["en", pytest.param("de", marks=pytest.mark.slow)])
def test_every_screen_is_accessible_fits_a_phone_comes_back_after_a_reload_and_asks_nobody_else(
    open_page: OpenPage, server: Server, pictures: Path, language: str
) -> None:
    study = FakeStudy.at(*fake.every_screen().values())
    person = study.people["token-of-person-1"]
    person.language = language
    page = open_page("/healthz")
    for name, step in fake.every_screen().items():
        person.steps = [step]
        resize(page, DESKTOP)
        study.open(page) if name == "consent" else page.reload()
        title = page.locator("#study-screen h1")
        expect(title).to_be_focused()
        assert violations(page) == [], name
        page.screenshot(path=pictures / f"study-{name}-{language}.png", full_page=True)
        resize(page, PHONE)
        assert overflow(page) == 0, name
        page.screenshot(path=pictures / f"study-{name}-{language}-phone.png", full_page=True)
        stops = page.get_by_role("button", name={"en": "Stop the study", "de": "Studie beenden"}[language])
        expect(stops).to_have_count(0 if name.startswith(("consent", "code", "ended")) else 1)
    assert {url for url in study.urls if not url.startswith((server.url, "data:"))} == set()


@pytest.mark.slow
def test_a_tab_in_which_nobody_said_ready_leaves_the_game_to_the_one_that_did(open_page: OpenPage) -> None:
    seat = {"id": "r1", "token": "t", "seat": 0, "path": "/play/r1"}
    study = FakeStudy.at(fake.play(), fake.play("playing", room=seat))
    page = open_page("/healthz")
    study.open(page)
    expect(page.get_by_role("button", name="I am ready")).to_be_visible()
    study.people["token-of-person-1"].next()  # said in the other tab
    expect(page.get_by_role("button", name="Back to the game")).to_be_visible(timeout=20_000)
    assert not any(url.endswith("/play/r1") for url in study.urls)


@pytest.mark.slow
@pytest.mark.parametrize("language", ["en", "de"])
def test_on_a_phone_the_ready_button_of_a_round_is_in_sight(open_page: OpenPage, language: str) -> None:
    study = FakeStudy.at(fake.play(kind="practice", map_name="Simple", limit_s=120))
    person = study.people["token-of-person-1"]
    person.language = language
    page = open_page("/healthz", has_touch=True, is_mobile=True)
    study.open(page)
    for step in (person.steps[0], fake.play(map_name="AdaptiveAssist"), fake.play(map_name="HandOff")):
        person.steps = [step]
        page.reload()
        for width, height in ((375, 553), (390, 664), (360, 640)):
            page.set_viewport_size({"width": width, "height": height})
            expect(page.locator(".round-action button")).to_be_in_viewport(ratio=1)
            expect(page.locator(".map-picture")).to_be_in_viewport(ratio=1)
            assert overflow(page) == 0


def test_arriving_by_a_platforms_link_takes_its_parameters_and_leaves_none_in_the_address(open_page: OpenPage) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])], asks_code=False)
    page = open_page("/healthz")
    study.open(page, "?PROLIFIC_PID=5f00&STUDY_ID=s1&SESSION_ID=x9")
    heading(page, "Taking part in a research study")
    assert study.sent("/arrive") == [
        {"parameters": {"PROLIFIC_PID": "5f00", "STUDY_ID": "s1", "SESSION_ID": "x9"}, "language": "en", "known": []}
    ]
    assert page.url.endswith("/study")
    assert page.evaluate("localStorage.getItem('movingout-study-token')") == "token-of-person-1"


def test_a_typed_code_is_needed_and_a_wrong_one_is_explained(browser: Browser, server: Server) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])])
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        heading(page, fake.TITLE)
        expect(page).to_have_title(fake.TITLE)
        assert violations(page) == []
        press(page, "Tab", "Enter")
        expect(page.get_by_role("alert")).to_contain_text("Please type your code")
        study.refusals["/arrive"] = (403, "code_unknown", "server words")
        page.keyboard.type("WRONG")
        press(page, "Enter")
        expect(page.get_by_role("alert")).to_contain_text("This code is unknown")
        study.refusals.clear()
        press(page, "Enter")
        heading(page, "Taking part in a research study")
        expect(page).to_have_title(f"Taking part in a research study · {fake.TITLE}")


def test_consent_needs_its_boxes_and_no_is_an_answer(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.consent(), fake.questions(DEMOGRAPHICS, "form"))
    page = open_page("/healthz")
    study.open(page)
    heading(page, "Taking part in a research study")
    page.get_by_role("button", name="I agree").click()
    expect(page.get_by_role("alert")).to_contain_text("tick every required box")
    expect(page.get_by_label("I am 18 or older.")).to_be_focused()
    page.get_by_label("I am 18 or older.").check()
    expect(page.get_by_role("alert").filter(has_text="required box")).to_have_count(0)
    page.get_by_label("I am 18 or older.").uncheck()
    page.get_by_label("My recordings may be published").check()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save a copy").click()
    copy = Path(download.value.path()).read_text(encoding="utf-8")
    assert "This is research" in copy
    assert re.findall(r"<p>([☐☑] .*?)</p>", copy) == [
        "☐ I am 18 or older. (required)", "☑ My recordings may be published without my name.",
    ]  # fmt: skip
    assert f"Taking part in a research study · {fake.TITLE}</title>" in copy
    assert re.search(r"Version 1 of this page, saved on .*20\d\d", copy)
    page.get_by_label("My recordings may be published").uncheck()
    page.get_by_label("I am 18 or older.").focus()
    press(page, "Space", "Tab", "Tab", "Enter")
    heading(page, "About you")
    assert study.sent("/next") == [{"key": "consent", "boxes": ["adult"]}]
    study.people["token-of-person-1"].steps = [fake.consent()]
    page.reload()
    page.get_by_role("button", name="I do not agree").click()
    heading(page, "Thank you for reading")


def test_all_kinds_of_questions_are_answered_by_keyboard_alone_and_saved_at_each_press(open_page: OpenPage) -> None:
    two = fake.questions(DEMOGRAPHICS, "form")
    two["items"] = [two["items"][0], fake.questions(NASA_TLX)["items"][0], fake.questions(PAPER)["items"][0]]
    two["items"].append(fake.questions(PAPER)["items"][-1])
    study = FakeStudy.at(two, fake.code())
    page = open_page("/healthz")
    study.open(page)
    heading(page, "About you")
    press(page, "Tab", "Space", "ArrowRight", "Tab")  # 18-24, then 25-34
    press(page, "ArrowRight", "ArrowRight", "Tab", "Tab")  # past "I prefer not to answer"
    press(page, "Space", "ArrowRight", "ArrowRight", "Tab")
    expect(page.locator(".questionnaire-status")).to_have_attribute("data-waiting", "0")
    page.get_by_role("button", name="Next").press("Enter")
    page.get_by_label(re.compile("What else would you like")).focus()
    page.keyboard.type("It waited for me.")
    press(page, "Tab", "Tab", "Enter")
    heading(page, "Thank you")
    assert study.answers() == {
        "age": (1, ""),
        "mental": (12, ""),
        "teamwork": (3, ""),
        "comment": (-1, "It waited for me."),
    }
    assert all(body["elapsed_ms"] >= body["hidden_ms"] >= 0 for body in study.sent("/answer"))


def test_what_is_missing_is_named_and_not_to_answer_is_an_answer(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.questions(PAPER, letter="B"), fake.code())
    page = open_page("/healthz")
    study.open(page)
    expect(page.get_by_text("Partner B · Questions 1–3 of 10")).to_be_visible()
    page.get_by_role("button", name="Next").click()
    expect(page.get_by_role("alert")).to_contain_text("3 answers are missing")
    expect(page.locator("input[name=teamwork][value='1']")).to_be_focused()
    assert violations(page) == []
    for item in PAPER.items[:3]:
        page.locator(f"input[name={item.id}][value='-1']").check()
    expect(page.locator(".problem")).to_be_empty()
    page.get_by_role("button", name="Next").click()
    expect(page.get_by_text("Questions 4–6 of 10")).to_be_visible()
    page.get_by_role("button", name="Back").click()
    expect(page.locator("input[name=teamwork][value='-1']")).to_be_checked()


def test_the_waiting_room_counts_and_goes_on_by_itself_when_somebody_comes(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.waiting(since_s=72))
    page = open_page("/healthz")
    study.open(page)
    expect(page.get_by_text(re.compile("You have waited 1:1"))).to_be_visible()
    study.people["token-of-person-1"].steps = [fake.waiting(since_s=301)]
    expect(page.get_by_text("Just a moment, we are about to continue…")).to_be_visible()
    study.people["token-of-person-1"].steps = [fake.play()]
    heading(page, "Hand Off")


def test_a_round_is_played_on_the_game_page_which_leads_back(
    open_page: OpenPage, server: Server, pictures: Path
) -> None:
    room = server.make_room("Simple", red="idle", limit_ticks=10)
    seat = {"id": room["room"], "token": room["tokens"][0], "seat": 0, "path": room["join_path"]}
    study = FakeStudy.at(fake.play(), fake.play("playing", room=seat), fake.code())
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="I am ready").click()
    page.wait_for_url("**/play/*")
    expect(page.get_by_text("Round 3 of 12 · Partner A")).to_be_visible()
    expect(page.get_by_text("One round")).to_be_hidden()
    wait_for(page, "game.phase === 'series_over'")
    expect(page.get_by_role("heading", name="Time is up")).to_be_focused()
    expect(page.get_by_role("button", name="Play it again")).to_have_count(0)
    page.screenshot(path=pictures / "study-game-over.png")
    study.people["token-of-person-1"].next()
    page.get_by_role("button", name="Continue").click()
    heading(page, "Thank you")


@pytest.mark.slow
def test_practice_may_be_ended_and_stop_in_the_game_asks_about_the_data(
    open_page: OpenPage, server: Server, pictures: Path
) -> None:
    room = server.practice()
    seat = {"id": room["room"], "token": room["tokens"][0], "seat": 0, "path": room["join_path"]}
    running = fake.play("playing", kind="practice", map_name="Simple", room=seat)
    study = FakeStudy.at(fake.play(kind="practice", map_name="Simple"), running, fake.play())
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'playing'")
    page.get_by_role("button", name="Pause or stop…").click()
    wait_for(page, "game.phase === 'paused'")
    expect(page.locator("#overlay .invisible")).to_have_count(0)
    page.get_by_role("button", name="Stop the study").click()
    expect(page.get_by_role("dialog")).to_contain_text("You may stop at any time")
    assert violations(page) == []
    page.emulate_media(color_scheme="light")
    page.screenshot(path=pictures / "study-game-stop.png")
    page.get_by_role("button", name="No, continue").click()
    expect(page.locator("#overlay").get_by_role("button", name="Continue")).to_be_focused()  # Space does what is said
    page.get_by_role("button", name="Enough practice").click()
    heading(page, "Hand Off")
    assert study.sent("/next")[-1] == {"key": "practice/Simple", "done": True}
    assert study.sent("/stop") == []


@pytest.mark.slow
def test_a_round_that_begins_behind_the_question_whether_to_stop_waits_for_the_answer(
    open_page: OpenPage, server: Server
) -> None:
    room = server.practice()
    seat = {"id": room["room"], "token": room["tokens"][0], "seat": 0, "path": room["join_path"]}
    page = open_page("/healthz")
    FakeStudy.at(fake.play(), fake.play("playing", room=seat)).open(page)
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'countdown'")
    page.locator("#stop").click()
    expect(page.get_by_role("dialog")).to_be_visible()
    wait_for(page, "game.phase === 'paused'")
    page.get_by_role("button", name="No, continue").click()
    expect(page.locator("#overlay").get_by_role("button", name="Continue")).to_be_focused()


def test_stop_with_deletion_gives_a_code_and_says_what_becomes_of_the_data(open_page: OpenPage, pictures: Path) -> None:
    study = FakeStudy.at(fake.questions(PAPER, letter="A"))
    page = open_page("/healthz")
    study.open(page)
    page.get_by_role("button", name="Stop the study").click()
    expect(page.get_by_role("button", name="No, continue")).to_be_focused()
    page.screenshot(path=pictures / "study-stop.png")
    press(page, "Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.get_by_role("button", name="Stop the study").click()
    page.get_by_role("button", name="Stop, delete my data").click()
    heading(page, "The study was stopped")
    expect(page.locator("#completion-code")).to_have_text("K7QX4WPL2M")
    expect(page.get_by_text("Your data are deleted.")).to_be_visible()
    assert study.sent("/stop") == [{"keep": False}]


def test_the_debrief_asks_and_the_code_can_be_copied(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.debrief(), fake.code())
    page = open_page("/healthz", permissions=["clipboard-read", "clipboard-write"])
    study.open(page)
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_role("alert")).to_contain_text("Please choose one of the two")
    press(page, "ArrowDown", "ArrowUp")
    expect(page.locator(".problem")).to_be_empty()
    page.get_by_role("button", name="Continue").press("Enter")
    expect(page.get_by_text("$20.67 for 62 min")).to_be_visible()
    expect(page.get_by_text("Show this code to the experimenter.")).to_be_visible()
    expect(page.locator("#completion-code")).to_have_attribute("translate", "no")  # by a browser's translator
    page.get_by_role("button", name="Copy the code").click()
    expect(page.get_by_text("Copied.")).to_be_visible()
    assert page.evaluate("navigator.clipboard.readText()") == "K7QX4WPL2M"
    assert study.sent("/next") == [{"key": "debrief", "keep": True}]
    page.get_by_role("button", name="Next person at this screen").click()
    heading(page, fake.TITLE)


def test_whom_a_platform_sent_is_not_asked_for_another_person_at_this_screen(open_page: OpenPage) -> None:
    earned = {"minutes": 0.2, "amount": 0.07, "currency": "USD"}  # stopped after some seconds
    address = "https://example.org/complete"
    study = FakeStudy.at(fake.code(completion_url=address, from_platform=True, shared_code=True, earned=earned))
    page = open_page("/healthz")
    study.open(page)
    heading(page, "Thank you")
    expect(page.get_by_text("$0.07 for 0.2 min", exact=True)).to_be_visible()
    expect(page.get_by_text("Enter this code on the site that sent you here.")).to_be_visible()
    expect(page.get_by_text("tell the experimenter your ID on the site that sent you here.")).to_be_visible()
    expect(page.get_by_role("button", name="Next person at this screen")).to_have_count(0)


def test_who_came_by_a_link_of_their_own_is_not_asked_for_the_next_person_and_an_unpaid_code_is_not_for_pay(
    open_page: OpenPage,
) -> None:
    told = "<h1>What it was about</h1><p>Partner A: dp</p>"
    study = FakeStudy.at(fake.debrief(), fake.code("withdrew", earned=None, html=told, ask_to_keep=True))
    study.pays = False
    page = open_page("/healthz", script="localStorage.setItem('movingout-study-by-link', '1')")
    study.open(page)
    expect(page.get_by_text("You still get your code.", exact=False)).to_be_visible()
    expect(page.get_by_text("payment")).to_have_count(0)
    page.get_by_role("button", name="Stop the study").click()
    expect(page.get_by_role("dialog")).to_contain_text("You get a code.")
    expect(page.get_by_role("dialog")).not_to_contain_text("paid")
    page.get_by_role("button", name="No, continue").click()
    page.get_by_label("You may keep my data").check()
    page.get_by_role("button", name="Continue", exact=True).click()
    heading(page, "The study was stopped")
    expect(page.get_by_role("heading", name="What it was about", level=2)).to_be_visible()
    expect(page.get_by_text("Partner A: dp")).to_be_visible()
    expect(page.get_by_text("If it speaks of a choice about your data")).to_be_visible()
    expect(page.get_by_role("button", name="Next person at this screen")).to_have_count(0)
    expect(page.get_by_text("to be paid")).to_have_count(0)


def test_the_language_can_be_changed_on_every_screen(open_page: OpenPage, pictures: Path) -> None:
    study = FakeStudy.at(fake.input_check())
    page = open_page("/healthz")
    study.open(page)
    page.get_by_label("Language").select_option("de")
    heading(page, "Probieren Sie die Steuerung aus")
    assert page.evaluate("document.documentElement.lang") == "de"
    page.screenshot(path=pictures / "study-german.png", full_page=True)
    page.reload()
    heading(page, "Probieren Sie die Steuerung aus")


@pytest.mark.parametrize(
    ("offered", "locale", "chosen", "name", "button"),
    [
        (("en-GB", "de"), "en-US", "en-GB", "British English", "Begin"),
        (("en", "de-AT"), "de-DE", "de-AT", "Österreichisches Deutsch", "Beginnen"),
    ],
)
def test_a_language_of_a_country_is_offered_and_read_in_the_words_of_its_language(
    open_page: OpenPage, offered: tuple[str, ...], locale: str, chosen: str, name: str, button: str
) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])], asks_code=False, languages=offered)
    page = open_page("/healthz", locale=locale)
    study.open(page)
    expect(page.locator(".language-select")).to_have_value(chosen)
    expect(page.locator(".language-select option:checked")).to_have_text(name)
    page.get_by_role("button", name=button).click()
    heading(page, "Taking part in a research study")
    assert study.sent("/arrive")[0]["language"] == page.evaluate("document.documentElement.lang") == chosen
    expect(page.locator(".language-select")).to_have_value(chosen)


@pytest.mark.slow
def test_a_whole_study_can_be_gone_through_with_nothing_but_the_keyboard(open_page: OpenPage, server: Server) -> None:
    practice, room = server.practice(), server.make_room("Simple", red="idle", limit_ticks=10)
    seats = [
        {"id": one["room"], "token": one["tokens"][0], "seat": 0, "path": one["join_path"]} for one in (practice, room)
    ]
    study = FakeStudy.at(
        fake.consent(),
        fake.questions(DEMOGRAPHICS, "form"),
        fake.input_check(),
        fake.play(kind="practice", map_name="Simple"),
        fake.play("playing", kind="practice", map_name="Simple", room=seats[0]),
        fake.play(),
        fake.play("playing", room=seats[1]),
        fake.questions(PAPER, letter="A"),
        fake.questions(NASA_TLX),
        {"key": "break", "kind": "break", "seconds": 120},
        fake.debrief(),
        fake.code(),
        leaves_rooms=True,
    )
    page = open_page("/healthz")
    study.open(page)
    participant = KeyboardParticipant(page)
    participant.walk()
    assert participant.seen == [
        *("consent", "form", "input-check", "practice", "round"),
        *("questionnaire", "questionnaire", "break", "debrief", "code"),
    ]
    expected = [item.id for one in (DEMOGRAPHICS, PAPER, NASA_TLX) for item in one.items]
    assert list(study.answers()) == expected
