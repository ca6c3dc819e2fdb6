"""The questions at the end of a series: by keyboard alone, saved per click, resumed, retried."""

import json
import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from movingout.study.questionnaire import PAPER
from tests.browser.pages import complaining_page, overflow, violations
from tests.browser.support import PHONE, Server, seat_tokens_script, wait_for

OpenPage = Callable[..., Page]


def short_room(server: Server) -> dict[str, Any]:
    """A series that is over a second after its start."""
    return server.make_room("Simple", red="idle", limit_ticks=10)


def play_to_the_questions(page: Page) -> Page:
    wait_for(page, "game.phase === 'lobby' && game.status === 'open'")
    page.get_by_role("button", name="I am ready").click()
    wait_for(page, "game.phase === 'series_over'")
    page.get_by_role("button", name="Answer 10 questions").click()
    expect(page.get_by_role("heading", name="About your partner")).to_be_focused()
    return page


def saved_answers(server: Server, room: dict[str, Any]) -> dict[str, tuple[int, str]]:
    """The newest answer to each question that lies on the server's disk."""
    path = server.data / "answers" / f"{room['room']}-0.jsonl"
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return {line["question"]: (line["value"], line["text"]) for line in lines}


def answer(page: Page, question: str, value: int) -> None:
    page.locator(f"input[name={question}][value='{value}']").check(force=True)


def all_saved(page: Page) -> None:
    expect(page.locator(".questionnaire-status[data-waiting='0']")).to_be_visible()


@pytest.mark.slow
def test_all_questions_are_answered_by_keyboard_alone(server: Server, open_page: OpenPage) -> None:
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room))
    for number in range(9):
        page.keyboard.press("Tab")
        page.keyboard.press("Space")  # 1
        for _ in range(number % 7):
            page.keyboard.press("ArrowRight")
        if number % 3 == 2:  # from the last scale past Back (absent on the first page) to Next
            for _ in range(1 if number == 2 else 2):
                page.keyboard.press("Tab")
            all_saved(page)
            page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    page.keyboard.type("It waited for me.")
    page.keyboard.press("Tab")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Thank you for your answers.")).to_be_focused()
    expect(page.get_by_role("button", name="Next map")).to_be_visible()  # and one can play on
    expected = {item.id: (number % 7 + 1, "") for number, item in enumerate(PAPER.items[:9])}
    assert saved_answers(server, room) == {**expected, "comment": (-1, "It waited for me.")}


def test_two_clicks_in_one_task_turn_one_page_and_finish_once(server: Server, open_page: OpenPage) -> None:
    """The page that complains fails the test: of the second click the browser said that its form is gone."""
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room))
    twice = "button => { button.click(); button.click(); }"
    for first in range(0, 9, 3):
        for item in PAPER.items[first : first + 3]:
            answer(page, item.id, 4)
        page.get_by_role("button", name="Next").evaluate(twice)
    all_saved(page)
    page.get_by_role("button", name="Finish").evaluate(twice)
    expect(page.get_by_text("Thank you for your answers.")).to_be_focused()


@pytest.mark.slow
def test_the_questions_of_two_at_one_screen_have_one_width_below_whose_they_are(
    server: Server, open_page: OpenPage
) -> None:
    room = server.make_room("Simple", blue="here", red="here", limit_ticks=10)
    page = open_page(room["join_path"], room, viewport={"width": 768, "height": 640})
    for key in ("Space", "Enter"):
        expect(page.locator("#ready .button-small")).to_have_count(2 if key == "Space" else 1)
        page.keyboard.press(key)
    page.get_by_role("button", name=re.compile("Answer .* questions")).click()
    form, whose = page.locator(".questionnaire").last, page.get_by_text("Questions for Blue")
    sides = []
    for first in (0, 3):
        expect(form).to_be_visible()
        sides.append(form.evaluate("form => [form.getBoundingClientRect().left, form.getBoundingClientRect().right]"))
        left, top = whose.evaluate("whose => [whose.getBoundingClientRect().left, whose.getBoundingClientRect().top]")
        assert left == sides[0][0]
        assert top >= 12, "not at the edge of the window"
        for item in PAPER.items[first : first + 3]:
            answer(page, item.id, 1)
        page.get_by_role("button", name="Next").click()
    assert sides[0] == sides[1]


@pytest.mark.slow
def test_every_page_of_questions_and_its_complaint_is_accessible_in_both_themes(
    server: Server, open_page: OpenPage
) -> None:
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room))
    page.get_by_role("button", name="Next").click()
    assert violations(page) == []  # with everything missing
    for first in range(0, 9, 3):
        for item in PAPER.items[first : first + 3]:
            answer(page, item.id, 4)
        assert violations(page) == []
        page.get_by_role("button", name="Next").click()
    assert violations(page) == []  # the free text


@pytest.mark.slow
def test_what_is_missing_is_announced_and_gets_the_focus(server: Server, open_page: OpenPage) -> None:
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room))
    answer(page, "teamwork", 6)
    page.get_by_role("button", name="Next").click()
    expect(page.get_by_role("alert").filter(has_text="2 answers are missing")).to_be_visible()
    expect(page.locator("input[name=humanlike][value='1']")).to_be_focused()
    answer(page, "humanlike", -1)  # "I prefer not to answer" is an answer
    expect(page.get_by_role("alert").filter(has_text="One answer is missing")).to_be_visible()
    expect(page.get_by_text("Please choose one.").locator("visible=true")).to_have_count(1)
    answer(page, "reasonable", 7)
    expect(page.get_by_role("alert").filter(has_text="missing")).to_have_count(0)
    page.get_by_role("button", name="Next").click()
    expect(page.get_by_text("questions 4–6 of 10")).to_be_visible()
    all_saved(page)
    assert saved_answers(server, room) == {"teamwork": (6, ""), "humanlike": (-1, ""), "reasonable": (7, "")}


@pytest.mark.slow
def test_a_reload_goes_on_where_the_answers_end(server: Server, open_page: OpenPage) -> None:
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room))
    for question in ("teamwork", "humanlike", "reasonable"):
        answer(page, question, 5)
    page.get_by_role("button", name="Next").click()
    answer(page, "physics", 2)
    all_saved(page)
    page.reload()
    page.get_by_role("button", name="Answer 10 questions").click()
    expect(page.get_by_text("questions 4–6 of 10")).to_be_visible()
    expect(page.locator("input[name=physics][value='2']")).to_be_checked()
    page.get_by_role("button", name="Back").click()
    expect(page.locator("input[name=teamwork][value='5']")).to_be_checked()


@pytest.mark.slow
def test_answers_given_without_a_connection_arrive_when_it_is_back(server: Server, browser: Browser) -> None:
    room = short_room(server)
    with complaining_page(browser, server, "") as page:
        page.add_init_script(seat_tokens_script(room))
        page.goto(room["join_path"])
        play_to_the_questions(page)
        page.context.set_offline(True)
        answer(page, "teamwork", 3)
        answer(page, "teamwork", 4)
        expect(page.get_by_text("No connection. Your answers wait here")).to_be_visible()
        page.context.set_offline(False)
        all_saved(page)
        assert saved_answers(server, room) == {"teamwork": (4, "")}


@pytest.mark.slow
def test_after_a_reconnection_what_was_open_is_still_open_and_answers_are_saved_with_the_new_token(
    server: Server, open_page: OpenPage
) -> None:
    room = short_room(server)
    page = open_page("/healthz")
    page.context.add_init_script(seat_tokens_script(room))
    lines: list[WebSocketRoute] = []

    def between(line: WebSocketRoute) -> None:
        line.connect_to_server()
        lines.append(line)

    def reconnect() -> None:
        token = page.evaluate("Object.values(sessionStorage).join()")
        lines[-1].close(code=4008)
        wait_for(page, f"Object.values(sessionStorage).join() !== {json.dumps(token)} && game.status === 'open'")
        page.wait_for_timeout(300)  # the result comes after the welcome

    page.route_web_socket("**/ws/*", between)
    page.goto(room["join_path"])
    play_to_the_questions(page)
    answer(page, "teamwork", 3)
    reconnect()
    answer(page, "humanlike", 4)
    all_saved(page)
    expect(page.locator(".questionnaire-status")).to_have_text("Every answer is saved at once")
    assert saved_answers(server, room) == {"teamwork": (3, ""), "humanlike": (4, "")}
    page.get_by_role("button", name="Skip the questions").click()
    page.get_by_text("Details").click()
    reconnect()
    expect(page.locator("[data-measure=tcr]")).to_be_visible()
    expect(page.locator("details summary")).to_be_focused()


@pytest.mark.slow
def test_on_a_phone_the_scales_fit_with_large_targets_and_the_questions_may_be_skipped(
    server: Server, open_page: OpenPage
) -> None:
    room = short_room(server)
    page = play_to_the_questions(open_page(room["join_path"], room, viewport=PHONE))
    assert overflow(page) == 0
    sizes = page.locator(".likert-option").evaluate_all(
        "boxes => boxes.map(box => [box.offsetWidth, box.offsetHeight, box.getBoundingClientRect().top])"
    )
    assert len(sizes) == 21
    assert min(width for width, _, _ in sizes) >= 42  # 44 with the gap around it
    assert min(height for _, height, _ in sizes) >= 44
    assert all(len({top for _, _, top in sizes[at : at + 7]}) == 1 for at in (0, 7, 14)), "a scale is one line"
    page.get_by_role("button", name="Skip the questions").click()
    expect(page.get_by_role("button", name="Answer 10 questions")).to_be_focused()
    expect(page.get_by_role("button", name="Play again")).to_be_visible()
