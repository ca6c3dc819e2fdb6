"""The study's pages when the server or the connection fails: nothing is lost, and what is wrong is said."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from movingout.study.questionnaire import PAPER, TEXT_LIMIT, Questionnaire, QuestionnaireItem
from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.pages import complaining_page, heading, overflow, violations
from tests.browser.study_fake import FakePerson, FakeStudy
from tests.browser.support import STORAGE_FORBIDDEN, Server

pytestmark = pytest.mark.slow

FREE = Questionnaire(id="free", title="In your words", items=(QuestionnaireItem("why", "text", "Why", "Why?"),))


def test_a_platforms_link_that_fails_for_now_is_tried_again_with_all_it_says(browser: Browser, server: Server) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])], asks_code=False)
    study.refusals[""] = (503, "starting", "")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page, "?PROLIFIC_PID=5f00")
        expect(page.get_by_text("The study does not answer yet")).to_be_visible()
        study.refusals = {"": (500, "broken", "The study could not be read. The experimenter was told.")}
        heading(page, "This did not work")
        expect(page.get_by_role("alert")).to_contain_text("The experimenter was told")
        assert violations(page) == []
        study.refusals = {"/arrive": (507, "not_saved", "read-only")}
        page.get_by_role("button", name="Try again").click()
        expect(page.locator("#study-banner")).to_contain_text("cannot take this right now")
        study.refusals = {"/arrive": (429, "too_many_arrivals", "")}
        expect(page.get_by_label("Your code")).to_have_count(0)
        study.refusals.clear()
        heading(page, "Taking part in a research study")  # by itself
        assert study.sent("/arrive")[-1]["parameters"] == {"PROLIFIC_PID": "5f00"}
        assert page.url.endswith("/study")


def test_who_came_by_a_link_and_is_asked_again_is_the_same_person_until_they_have_consented(
    browser: Browser, server: Server
) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()]), FakePerson([fake.consent(), fake.code()])], asks_code=False)
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page, "?PROLIFIC_PID=5f00")
        heading(page, "Taking part in a research study")
        study.people.clear()  # the study file was mended
        page.reload()
        heading(page, "Taking part in a research study")  # by itself
        assert [body["parameters"] for body in study.sent("/arrive")] == [{"PROLIFIC_PID": "5f00"}] * 2
        page.get_by_label("I am 18 or older.").check()
        page.get_by_role("button", name="I agree").click()
        heading(page, "Thank you")
        assert page.evaluate("sessionStorage.getItem('movingout-study-link')") is None, "no longer than needed"


def two_at_one_screen(page: Page, *steps: fake.Step) -> FakeStudy:
    study = FakeStudy.at(*steps, group=2, asks_code=False)
    study.people["token-of-person-2"] = FakePerson([*steps])
    study.open(page)
    expect(page.locator("#study-who")).to_be_visible()
    return study


def first_leaves(study: FakeStudy, page: Page) -> None:
    """The page hears that the first person has declined."""
    study.people["token-of-person-1"].steps = [fake.code("declined", code=None, earned=None)]
    expect(page.locator("#study-who")).to_be_hidden(timeout=20_000)


def hold(page: Page, url: re.Pattern[str]) -> list[Route]:
    """Requests that wait for their answer."""
    held: list[Route] = []
    page.route(url, lambda route: held.append(route))
    return held


def test_where_the_first_declines_and_the_answer_comes_after_other_news_the_second_goes_on(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    study = two_at_one_screen(page, fake.consent(), fake.input_check())
    held = hold(page, re.compile("/decline"))
    page.get_by_label("I am 18 or older.").check()
    page.get_by_role("button", name="I do not agree").click()
    first_leaves(study, page)
    expect(page.get_by_label("I am 18 or older.")).not_to_be_checked()  # their own screen, not the one of the first
    with page.expect_response("**/api/study/decline"):
        study._answer(held[0])
    page.get_by_label("I am 18 or older.").check()
    page.get_by_role("button", name="I agree").click()
    heading(page, "Try your controls")


def test_a_language_that_arrives_when_the_first_has_left_is_that_of_the_second(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    study = two_at_one_screen(page, fake.consent(), fake.input_check())
    held = hold(page, re.compile("lang="))
    page.get_by_label("Language").select_option("de")
    first_leaves(study, page)
    for route in held:
        study._answer(route)
    expect(page.get_by_role("button", name="Ich stimme zu")).to_be_visible()
    page.get_by_label("I am 18 or older.").check()
    page.get_by_role("button", name="Ich stimme zu").click()
    heading(page, "Probieren Sie die Steuerung aus")


def test_another_language_keeps_the_ticks_of_the_consent_and_the_time_of_a_break(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    page.clock.install()
    study = FakeStudy.at(fake.consent(), {"key": "break", "kind": "break", "seconds": 120})
    study.open(page)
    ticks = page.get_by_role("checkbox")
    ticks.nth(1).check()
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_role("button", name="Ich stimme zu")).to_be_visible()
    expect(ticks.nth(1)).to_be_checked()
    expect(ticks.nth(0)).not_to_be_checked()
    ticks.nth(0).check()
    page.get_by_role("button", name="Ich stimme zu").click()
    expect(page.get_by_text("Empfohlen: noch")).to_be_visible()
    page.clock.run_for(60_000)
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_text(re.compile("Suggested: (1:00|0:..) more"))).to_be_visible()
    assert study.sent("/next")[0]["boxes"] == ["adult", "release"]


def test_another_language_keeps_the_page_of_a_form(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    answers = {item.id: {"value": 4, "text": ""} for item in PAPER.items}
    FakeStudy.at({**fake.questions(PAPER), "answers": answers}).open(page)
    expect(page.get_by_text("Question 10 of 10")).to_be_visible()
    for _ in range(3):
        page.get_by_role("button", name="Back").click()
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_text("Fragen 1–3 von 10")).to_be_visible()
    page.get_by_role("button", name="Weiter").click()
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_text("Questions 4–6 of 10")).to_be_visible()


def test_who_has_left_before_they_stop_stops_nobody_else(open_page: OpenPage) -> None:
    page = open_page("/healthz")
    study = two_at_one_screen(page, fake.questions(PAPER, letter="A"))
    page.get_by_role("button", name="Stop the study").click()
    first_leaves(study, page)
    page.get_by_role("dialog").get_by_role("button", name="Stop, keep my data").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert study.people["token-of-person-2"].steps[0]["kind"] == "questionnaire"


def test_answers_given_without_a_connection_survive_closing_the_page_and_arrive_later(
    browser: Browser, server: Server
) -> None:
    study = FakeStudy.at(fake.questions(PAPER, letter="A"))
    study.refusals["/answer"] = (0, "", "")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        page.locator("input[name=teamwork][value='3']").check()
        page.locator("input[name=teamwork][value='4']").check()
        expect(page.get_by_text("No connection. Your answers wait here")).to_be_visible()
        study.heard.clear()
        study.refusals.clear()
        page.reload()
        expect(page.locator("input[name=teamwork][value='4']")).to_be_checked()
        expect(page.locator(".questionnaire-status")).to_have_attribute("data-waiting", "0")
        assert study.answers() == {"teamwork": (4, "")}


@pytest.mark.parametrize("comes", ["back", "next"])
def test_a_text_typed_without_a_connection_is_there_for_who_opens_their_link_again_and_for_nobody_else(
    browser: Browser, server: Server, comes: str
) -> None:
    person = FakePerson([fake.questions(FREE, "form")])
    study = FakeStudy(people={"before-they-left": person}, refusals={"/answer": (503, "starting", "")})
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        page.get_by_role("textbox").fill("They waited for me.")
        page.get_by_role("textbox").blur()
        expect(page.locator(".questionnaire-status")).to_have_attribute("data-waiting", "1")
        study.coming = [person if comes == "back" else FakePerson([fake.questions(FREE, "form")])]
        study.refusals.clear()
        page.goto("/healthz")
        study.heard.clear()
        page.goto("/study?PROLIFIC_PID=5f00")
        expect(page.get_by_role("textbox")).to_have_value("They waited for me." if comes == "back" else "")
        expect(page.locator(".questionnaire-status")).to_have_attribute("data-waiting", "0")
        assert study.answers() == ({"why": (-1, "They waited for me.")} if comes == "back" else {})
        assert page.evaluate("localStorage.getItem('movingout-study-unsent')") == "{}"


def test_a_server_that_is_away_is_waited_for_and_one_that_refuses_is_quoted(browser: Browser, server: Server) -> None:
    study = FakeStudy.at({"key": "break", "kind": "break", "seconds": 10}, fake.code())
    study.refusals["/next"] = (507, "not_saved", "No space left on device: /srv/data")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        page.get_by_role("button", name="Continue").click()
        expect(page.locator("#study-banner")).to_contain_text("keeps trying, and nothing is lost")
        study.refusals["/next"] = (0, "", "")
        expect(page.locator("#study-banner")).to_contain_text("No connection to the study")
        assert violations(page) == []
        study.refusals.clear()
        heading(page, "Thank you")
        expect(page.locator("#study-banner")).to_be_hidden()


def test_a_place_that_is_gone_and_a_view_that_fails_lead_to_a_page_that_says_so(
    browser: Browser, server: Server
) -> None:
    study = FakeStudy.at(fake.code())
    study.refusals["/view"] = (500, "internal", "Something went wrong in the study. The experimenter was told.")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        heading(page, "This did not work")
        assert violations(page) == []
        page.get_by_role("button", name="Try again").click()
        heading(page, "This did not work")
        study.refusals.clear()
        heading(page, "Thank you")  # by itself
        study.people.clear()
        page.reload()
        expect(page.get_by_role("alert")).to_contain_text("no longer has an open place in the study")


def test_where_somebody_has_finished_their_code_is_shown_only_when_asked_for(
    open_page: OpenPage, pictures: Path
) -> None:
    page = open_page("/", viewport={"width": 375, "height": 553})
    study = FakeStudy.at(fake.code(long_ago=True), asks_code=False)
    study.open(page)
    expect(page.get_by_text("Somebody has finished this study in this browser.")).to_be_visible()
    assert overflow(page) == 0 and violations(page) == []
    page.screenshot(path=pictures / "study-finished-here.png")
    expect(page.locator("#completion-code")).to_have_count(0)
    page.get_by_role("button", name="That was me: show my code").click()
    expect(page.locator("#completion-code")).to_have_text("K7QX4WPL2M")


def test_the_next_person_is_asked_in_their_own_language(open_page: OpenPage) -> None:
    page = open_page("/", locale="de-DE")
    page.evaluate("localStorage.setItem('movingout.language', 'en')")  # chosen by whoever has finished
    study = FakeStudy.at(fake.code(long_ago=True), asks_code=False)
    study.open(page)
    expect(page.get_by_text("In diesem Browser hat jemand die Studie abgeschlossen.")).to_be_visible()
    page.locator(".language-select").select_option("en")
    expect(page.get_by_text("Somebody has finished this study in this browser.")).to_be_visible()
    page.locator(".language-select").select_option("de")
    page.get_by_role("button", name="Das war ich").click()
    expect(page.get_by_role("button", name="Copy the code")).to_be_visible()  # the code in its owner's language


def test_a_link_that_is_refused_leaves_whoever_was_here_their_place(browser: Browser, server: Server) -> None:
    study = FakeStudy.at(fake.code(), asks_code=False)
    study.refusals["/arrive"] = (403, "other_device", "")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page, "?PROLIFIC_PID=5f00")
        expect(page.get_by_role("alert")).to_contain_text("another browser")
        page.locator(".language-select").select_option("de")
        study.refusals.clear()
        study.coming = [FakePerson([fake.consent()])]
        page.get_by_role("button", name="Beginnen").click()
        heading(page, "Taking part in a research study")
        assert study.sent("/arrive")[-1]["parameters"] == {"PROLIFIC_PID": "5f00"}, "it still is that link"
        study.refusals["/arrive"] = (403, "study_full", "")
        page.goto("/study?PROLIFIC_PID=7a11")
        expect(page.get_by_role("alert")).to_be_visible()
        page.goto("/study")
        heading(page, "Taking part in a research study")


def test_where_a_browser_keeps_nothing_nobody_begins_what_they_could_not_play(browser: Browser, server: Server) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])], asks_code=False)
    with complaining_page(browser, server, "/healthz") as page:
        study.install(page)
        page.add_init_script(STORAGE_FORBIDDEN)
        page.goto("/study?PROLIFIC_PID=5f00&lang=de")
        heading(page, "Das hat nicht geklappt")
        expect(page.get_by_role("alert")).to_contain_text("Erlauben Sie ihr Cookies")
        assert study.sent("/arrive") == []


def test_a_page_that_is_continued_elsewhere_keeps_its_language(browser: Browser, server: Server) -> None:
    study = FakeStudy.at({"key": "elsewhere", "kind": "ended-elsewhere"})  # in English, the study's first language
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page, "?lang=de")
        heading(page, "Sie haben in einem anderen Fenster weitergemacht")
        page.get_by_label("Sprache").select_option("en")
        heading(page, "You continued in another window")


def test_a_link_with_a_wrong_code_lets_it_be_set_right(browser: Browser, server: Server) -> None:
    study = FakeStudy(coming=[FakePerson([fake.consent()])], asks_code=False)
    study.refusals["/arrive"] = (403, "code_unknown", "")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page, "?code=ABC")
        expect(page.get_by_role("alert")).to_contain_text("This code is unknown")
        study.refusals.clear()
        page.get_by_label("Your code").fill("ABD")
        page.get_by_role("button", name="Begin").click()
        heading(page, "Taking part in a research study")
        assert study.sent("/arrive")[-1]["parameters"] == {"code": "ABD"}


def test_a_text_that_is_longer_than_what_fits_says_so(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.questions(FREE), fake.code("done"))
    page = open_page("/healthz")
    study.open(page)
    expect(page.get_by_text("up to 4,000 characters")).to_be_visible()
    page.get_by_role("textbox").focus()
    page.keyboard.insert_text("a" * (TEXT_LIMIT - 1))
    expect(page.get_by_text("This is as much as fits")).to_have_count(0)
    page.keyboard.insert_text("bcd")
    expect(page.get_by_text("This is as much as fits: 4,000 characters.")).to_be_visible()
    expect(page.get_by_role("textbox")).to_have_value("a" * (TEXT_LIMIT - 1) + "b")
    page.keyboard.press("Backspace")
    expect(page.get_by_text("This is as much as fits")).to_have_count(0)


def test_a_text_that_is_refused_for_good_stays_is_explained_and_is_not_sent_again(
    browser: Browser, server: Server
) -> None:
    study = FakeStudy.at(fake.questions(FREE), fake.code("done"))
    study.refusals["/answer"] = (422, "answer", "why takes at most 4000 characters")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        page.get_by_role("textbox").fill("Because.")
        page.get_by_role("button", name="Finish").click()
        expect(page.get_by_role("alert")).to_contain_text("does not fit its question")
        page.reload()
        expect(page.get_by_role("textbox")).to_have_value("Because.")
        expect(page.get_by_role("alert")).to_contain_text("What you typed stays here")
        assert len(study.sent("/answer")) == 1
        study.refusals.clear()
        page.get_by_role("textbox").fill("Therefore.")
        page.get_by_role("button", name="Finish").click()
        heading(page, "Thank you")
        assert study.answers() == {"why": (-1, "Therefore.")}


def test_a_text_of_an_earlier_page_that_was_refused_sends_people_back_to_it(browser: Browser, server: Server) -> None:
    texts = tuple(QuestionnaireItem(f"why{number}", "text", "Why", f"Why {number}?") for number in range(2))
    study = FakeStudy.at(fake.questions(Questionnaire(id="free", title="In your words", items=texts)), fake.code())
    study.refusals["/answer"] = (422, "answer", "why0 takes at most 4000 characters")
    with complaining_page(browser, server, "/healthz") as page:
        study.open(page)
        page.get_by_role("textbox").fill("Because.")
        with page.expect_response("**/api/study/answer"):
            page.get_by_role("button", name="Next").click()
        study.refusals.clear()
        expect(page.get_by_role("textbox")).to_have_value("")
        page.get_by_role("button", name="Finish").click()
        expect(page.get_by_role("textbox")).to_have_value("Because.")
        expect(page.get_by_role("alert")).to_contain_text("What you typed stays here")
        assert violations(page) == []
        page.get_by_role("textbox").fill("Therefore.")
        page.get_by_role("button", name="Next").click()
        page.get_by_role("button", name="Finish").click()
        heading(page, "Thank you")
    assert study.answers()["why0"] == (-1, "Therefore.")
