"""The experimenter's screen with a study that exists only in the browser's network: live, on a phone, by keyboard."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from movingout.server.api.middleware import content_security_policy
from tests.browser.pages import complaining_page, overflow, sent_body, violations
from tests.browser.support import PHONE, Server
from tests.support import ROOT

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
UNLOCKED = "if (location.protocol !== 'about:') sessionStorage.setItem('movingout.admin', 'the-token')"
LAST_ROUND = {"episode": "e1", "number": 3, "map": "HandOff", "title": "Hand Off", "valid": True}
NOON = 1_795_262_400.0
QR = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 8 8"><path d="M0 0h4v4z"/></svg>'


def participant(pid: str, **more: Any) -> dict[str, Any]:
    return {
        "pid": pid, "unit": 1, "partner_letter": "A", "partner_pid": None, "seat": 0, "step": "play/1/HandOff-1",
        "kind": "round", "title": "Hand Off", "position": {"done": 9, "total": 24}, "round": {"number": 8, "of": 12},
        "since_s": 40, "present": True, "rtt_ms": 24, "room": "r1", "phase": "playing", "tick": 310,
        "limit_ticks": 500, "late_ms": 1.3, "missed": 0, "recording": "recording", "outcome": None,
        "code_given": False, "episode": "e2", "last_round": LAST_ROUND, "paused": False, **more,
    }  # fmt: skip


class FakeDashboard:
    """Answers the experimenter's API; `state` may be changed while the page looks."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, dict[str, Any]]] = []
        self.refuse = ""
        self.state: dict[str, Any] = {
            "study": {
                "id": "human-study", "title": "Playing with partners",
                "titles": {"en": "Playing with partners", "de": "Mit Partnern spielen"},
            },
            "paused": False,
            "counts": {"planned": 32, "finished": 21, "group": 1, "active": 3, "waiting": 0},
            "participants": [
                participant("P4K7Q2"),
                participant("PX93LM", kind="questionnaire", room=None, tick=None, late_ms=None, recording=""),
                participant("P7TTB1", seat=1, present=False, phase="paused", late_ms=8.2, recording="the disk is full"),
                participant("P0DONE", kind="code", outcome="done", room=None, code_given=True),
            ],
            "alerts": [{"id": 1, "at": NOON, "text": "P7TTB1 was opened in a second window."}],
            "notes": [{"at": NOON, "text": "Gamepad 2 has a loose cable.", "pid": "P7TTB1"}],
            "server": {
                "late_p99_ms": 1.3, "missed": 0, "ticks": 184200,
                "disk_free_mb": 38000, "recordings": 412, "partial": 0,
            },
        }  # fmt: skip

    def open(self, page: Page) -> None:
        page.route("**/experimenter", self._page)
        page.route("**/api/experimenter/**", self._answer)
        page.goto("/experimenter")
        expect(page.locator("[data-pid=P4K7Q2]")).to_be_visible()

    def _page(self, route: Route) -> None:
        policy = {"content-security-policy": content_security_policy(route.request.url.split("/")[2])}
        body = (ROOT / "web" / "experimenter" / "experimenter.html").read_text(encoding="utf-8")
        route.fulfill(body=body, content_type="text/html; charset=utf-8", headers=policy)

    def _answer(self, route: Route) -> None:
        request = route.request
        path = request.url.partition("/api/experimenter/")[2].partition("?")[0]
        assert request.headers["authorization"] == "Bearer the-token"
        if request.method == "POST":
            self.heard.append((path, sent_body(request)))
        if request.method == "POST" and self.refuse:
            route.fulfill(status=409, json={"error": {"code": "refused", "message": self.refuse}})
        elif path == "live":
            route.fulfill(body=": beat\n\n", content_type="text/event-stream")
        elif path == "state":
            route.fulfill(json=self.state)
        elif path == "qr.svg":
            route.fulfill(body=QR, content_type="image/svg+xml")
        elif path == "payments.csv":
            route.fulfill(body="pid,minutes,amount\nP0DONE,62,20.67\n", content_type="text/csv")
        else:
            route.fulfill(json={"code": "K7QX4WPL2M", "path": "/study?code=K7QX4WPL2M"})


def until_heard(page: Page, study: FakeDashboard, *actions: str) -> None:
    """What was asked of the server so far, once it is that much."""
    for _ in range(50):
        if len(study.heard) >= len(actions):
            break
        page.wait_for_timeout(50)
    assert [action for action, _ in study.heard] == list(actions)


def test_who_needs_somebody_comes_first_and_partners_are_letters(open_page: OpenPage, pictures: Path) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    rows = page.locator("[data-pid]")
    assert rows.evaluate_all("rows => rows.map(row => row.dataset.pid)") == ["P7TTB1", "P4K7Q2", "PX93LM", "P0DONE"]
    expect(rows.nth(0)).to_contain_text("away")
    expect(rows.nth(0)).to_contain_text("not recording")
    expect(rows.nth(1)).to_contain_text("Partner A")
    expect(rows.nth(1)).to_contain_text("0:31 / 0:50")
    expect(rows.nth(1).get_by_role("link", name="Watch")).to_have_attribute("href", "/watch/r1")
    expect(rows.nth(2).get_by_role("link", name="Watch")).to_be_hidden()
    expect(page.get_by_text("21 of 32 finished · 3 here")).to_be_visible()
    assert violations(page) == []
    page.screenshot(path=pictures / "study-experimenter-dark.png", full_page=True)


def test_the_title_of_the_study_is_said_in_the_experimenters_language(open_page: OpenPage) -> None:
    page = open_page("/healthz", script=UNLOCKED, locale="de-DE")
    FakeDashboard().open(page)
    expect(page.get_by_role("heading", level=1)).to_have_text("Mit Partnern spielen")
    expect(page).to_have_title(re.compile("Mit Partnern spielen"))


def test_news_come_without_a_reload_and_the_keyboard_keeps_its_place(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    actions = page.get_by_role("button", name="Actions for PX93LM")
    actions.focus()
    study.state["participants"] = [participant("PNEW22"), *study.state["participants"][:3]]
    expect(page.locator("[data-pid=PNEW22]")).to_be_visible()
    expect(page.locator("[data-pid=P0DONE]")).to_have_count(0)
    expect(actions).to_be_focused()


def test_what_is_done_for_a_participant_needs_a_reason_and_is_sent_with_it(
    browser: Browser, server: Server, pictures: Path
) -> None:
    study = FakeDashboard()
    with complaining_page(browser, server, "/healthz") as page:
        page.add_init_script(UNLOCKED)
        study.open(page)
        page.get_by_role("button", name="Actions for P4K7Q2").click()
        assert violations(page) == []
        page.get_by_role("button", name="Mark round 3 invalid (Hand Off)").click()
        page.get_by_role("button", name="Mark round 3 invalid (Hand Off)").click()
        expect(page.get_by_role("alert").filter(has_text="a few words")).to_be_visible()
        page.get_by_label("Why it does not count").fill("Fire alarm")
        study.refuse = "This round is marked already."
        page.get_by_role("button", name="Mark round 3 invalid (Hand Off)").click()
        expect(page.get_by_role("alert").filter(has_text="marked already")).to_be_visible()
        assert violations(page) == []
        page.screenshot(path=pictures / "study-experimenter-action.png")
        study.refuse = ""
        page.get_by_role("button", name="Mark round 3 invalid (Hand Off)").click()
        expect(page.get_by_role("dialog")).to_have_count(0)
        action, body = study.heard[-1]
        assert (action, body["pid"], body["episode"], body["reason"]) == ("invalid", "P4K7Q2", "e1", "Fire alarm")


def test_a_pause_between_rounds_is_seen_and_ended_in_the_row(open_page: OpenPage, pictures: Path) -> None:
    study = FakeDashboard()
    study.state["participants"][1].update(paused=True, unit_paused=True, paused_s=72)
    study.state["participants"][3].update(code="K7QX4WPL2M", minutes=61.7)
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    row = page.locator("[data-pid=PX93LM]")
    expect(row).to_contain_text("paused 1:12")
    expect(page.get_by_role("button", name="Resume P")).to_have_count(1)
    expect(page.locator("[data-pid=P0DONE]")).to_contain_text("Code K7QX4WPL2M · 61.7 min")
    assert violations(page) == []
    page.emulate_media(color_scheme="light")
    page.screenshot(path=pictures / "study-experimenter-paused.png", full_page=True)
    row.get_by_role("button", name="Resume PX93LM").click()
    assert study.heard == [("resume", {"pid": "PX93LM"})]


def test_the_table_can_show_one_group(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.get_by_label("Show").select_option("finished")
    expect(page.locator("[data-pid]:visible")).to_have_count(1)
    expect(page.locator("[data-pid=P0DONE]")).to_be_visible()
    page.get_by_label("Show").select_option("waiting")
    expect(page.get_by_text("Nobody is in this group now.")).to_be_visible()


def test_the_round_stands_still_while_a_reason_is_asked_and_goes_on_when_it_is_not_given(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.get_by_role("button", name="Actions for P4K7Q2").click()
    page.get_by_role("button", name="Restart the round").click()
    expect(page.get_by_label("Why it is restarted")).to_be_focused()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    until_heard(page, study, "pause", "resume")
    page.get_by_role("button", name="Actions for P4K7Q2").click()
    page.get_by_role("button", name="Restart the round").click()
    page.get_by_label("Why it is restarted").fill("A fire drill")
    page.get_by_role("button", name="Restart the round").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    until_heard(page, study, "pause", "resume", "pause", "restart-round", "resume")
    first, first_end, second, second_end = [body["hold"] for _, body in study.heard if "hold" in body]
    assert first == first_end != second == second_end


def test_a_round_goes_on_when_the_page_is_left_while_a_reason_is_asked(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.get_by_role("button", name="Actions for P4K7Q2").click()
    page.get_by_role("button", name="Restart the round").click()
    until_heard(page, study, "pause")
    page.evaluate("dispatchEvent(new PageTransitionEvent('pagehide'))")
    until_heard(page, study, "pause", "resume")


def test_a_round_goes_on_when_the_page_is_left_before_the_pause_is_confirmed(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.route("**/api/experimenter/pause", lambda route: study.heard.append(("pause", sent_body(route.request))))
    page.get_by_role("button", name="Actions for P4K7Q2").click()
    page.get_by_role("button", name="Restart the round").click()
    until_heard(page, study, "pause")
    page.evaluate("dispatchEvent(new PageTransitionEvent('pagehide'))")
    until_heard(page, study, "pause", "resume")
    assert study.heard[0][1] == study.heard[1][1], "the same hold"


def test_everything_can_be_paused_and_alerts_are_put_away(open_page: OpenPage) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.get_by_role("button", name="Dismiss").click()
    expect(page.get_by_text("opened in a second window")).to_have_count(0)
    study.state["paused"] = True
    page.get_by_role("button", name="Pause all").click()
    expect(page.get_by_text("Everything is paused.")).to_be_visible()
    page.get_by_role("button", name="Resume all").click()
    assert [action for action, _ in study.heard] == ["pause", "resume"]


def test_why_not_everything_could_be_paused_stays_until_the_next_action(browser: Browser, server: Server) -> None:
    study = FakeDashboard()
    with complaining_page(browser, server, "/healthz") as page:
        page.add_init_script(UNLOCKED)
        study.open(page)
        study.refuse = "The disk is full."
        page.get_by_role("button", name="Pause all").click()
        problem = page.get_by_role("alert").filter(has_text="The disk is full.")
        expect(problem).to_have_text("The disk is full.")
        with page.expect_response("**/api/experimenter/state"):
            pass
        expect(problem).to_be_visible()
        study.refuse = ""
        page.get_by_role("button", name="Pause all").click()
        expect(problem).to_have_count(0)


def test_the_next_participants_link_is_a_code_to_scan_and_notes_and_payments_are_kept(
    open_page: OpenPage, server: Server, pictures: Path
) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED)
    study.open(page)
    page.get_by_role("button", name="Open next participant").click()
    expect(page.get_by_role("link", name="/study?code=K7QX4WPL2M")).to_have_attribute(
        "href", f"{server.url}/study?code=K7QX4WPL2M"
    )
    expect(page.locator(".loopback")).to_contain_text("movingout study serve FILE --host 0.0.0.0 --tls")
    page.wait_for_function("() => document.querySelector('.qr')?.naturalWidth > 0")
    assert violations(page) == []
    page.screenshot(path=pictures / "study-experimenter-next.png")
    page.get_by_role("button", name="Close", exact=True).click()
    page.get_by_label("What happened").fill("It is loud in the corridor.")
    page.get_by_role("button", name="Add a note").click()
    expect(page.get_by_text("Saved.")).to_be_visible()
    assert study.heard[-1] == ("note", {"text": "It is loud in the corridor."})
    with page.expect_download() as download:
        page.get_by_role("button", name="Download CSV").click()
    assert Path(download.value.path()).read_text(encoding="utf-8").startswith("pid,minutes,amount")


def test_a_phone_is_enough_to_run_the_room(open_page: OpenPage, pictures: Path) -> None:
    study = FakeDashboard()
    page = open_page("/healthz", script=UNLOCKED, viewport=PHONE)
    study.open(page)
    assert overflow(page) == 0
    assert violations(page) == []
    page.emulate_media(color_scheme="light")
    page.screenshot(path=pictures / "study-experimenter-phone.png", full_page=True)
    heights = page.locator(".actions .button:visible").evaluate_all("buttons => buttons.map(one => one.offsetHeight)")
    assert min(heights) >= 44
    page.get_by_role("button", name="Actions for PX93LM").click()
    page.get_by_role("button", name="End the study for them").click()
    page.get_by_label("Why they have to leave").fill("Feels unwell")
    assert overflow(page) == 0
    page.get_by_role("button", name="End the study for them").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert study.heard[-1][0] == "kick"
