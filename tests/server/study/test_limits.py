"""What one person can take from a served study, by floods or with the link of somebody else."""

import asyncio
import contextlib
import gc
import json
import sqlite3
import urllib.request
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.server.connection.admission import AdmissionControl
from movingout.server.study import participants as server_participants
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.arrivals import session_service
from movingout.server.study.arrivals.arrival_link import Arrival
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.participant_session import notify
from movingout.server.study.participants import CODE_LENGTH, Participants
from movingout.study.design.definition import NOTICED_S
from movingout.study.store.identity import UNMISTAKABLE
from movingout.study.store.store import MOST_CHANGES
from movingout.study.store.tables import answers, participants
from tests.server.live import ADMIN, WAIT_S, limits
from tests.server.study.support import Served, Visitor, served

pytestmark = pytest.mark.slow


def test_a_flood_of_arrivals_from_one_address_is_refused_and_keeps_nothing(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = AdmissionControl(limits(study_arrivals_per_minute=5), lambda: 0.0)
    monkeypatch.setattr(solo.live.host, "admission", few)
    before = len(solo.running.databases.store.rows(participants))
    refused = [answer["error"]["code"] for status, answer in (solo.arrive() for _ in range(20)) if status == 429]
    assert refused == ["too_many_arrivals"] * 15
    assert len(solo.running.databases.store.rows(participants)) == before + 5


def test_one_address_agrees_so_many_times_a_day_and_who_has_agreed_goes_on(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row with a code stays of each, also of those who want no data kept."""
    now = 0.0
    few = AdmissionControl(limits(study_consents_per_day=2), lambda: now)
    monkeypatch.setattr(solo.live.host, "admission", few)
    visitors = [solo.visitor() for _ in range(3)]
    for key, boxes in ((visitors[2].step["key"], list[str]()), ("another", ["adult"])):
        visitors[2].call("next", {"key": key, "boxes": boxes})  # neither agrees, and neither counts
    for visitor in visitors[:2]:
        visitor.agree()
    status, answer = visitors[2].call("next", {"key": visitors[2].step["key"], "boxes": ["adult"]})
    assert (status, answer["error"]["code"]) == (429, "too_many_arrivals")
    visitors[0].fill_in()
    assert not solo.running.participants[visitors[2].pid].has_consented
    now = 43_200.0
    visitors[2].agree()


def test_a_flood_of_arrivals_is_not_in_front_of_everybody_else(solo: Served) -> None:
    """At most one of them is when somebody moves on, and one when somebody of another address arrives."""
    running, done = solo.running, list[str]()
    service = SessionService(running)

    async def arrives(who: str, address: str) -> None:
        await service.arrive(Arrival("link", f"flood-{who}", {}), "en", address=address)
        done.append(address)

    async def moves_on() -> None:
        async with running.transaction():
            done.append("change")

    async def all_at_once() -> None:
        async with running.transaction():
            flood = [asyncio.create_task(arrives(str(number), "flood")) for number in range(6)]
            await asyncio.sleep(0)
            others = [asyncio.create_task(work) for work in (moves_on(), arrives("other", "other"))]
            await asyncio.sleep(0)
        await asyncio.gather(*flood, *others)

    asyncio.run_coroutine_threadsafe(all_at_once(), solo.live.loop).result(WAIT_S)
    assert done == ["flood", "change", "flood", "other", *["flood"] * 4]


def test_who_opens_the_link_and_leaves_is_forgotten_early_where_they_are_many(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A flood of arrivals from many addresses must not fill the memory for half an hour."""
    agreed = solo.visitor()
    agreed.agree()
    left = [weakref.ref(solo.running.participants[solo.visitor().pid]) for _ in range(6)]
    declined = solo.visitor()
    declined.call("decline", {})
    solo.later(NOTICED_S + 1)
    here = [solo.visitor() for _ in range(3)]
    monkeypatch.setattr(server_participants, "MOST_UNDECIDED", len(here) + 2)
    solo.look()
    gc.collect()
    assert sum(one() is None for one in left) == 4, "they are in no table any more"
    assert all(visitor.look()["step"]["kind"] == "consent" for visitor in here)
    assert agreed.look()["step"]["kind"] != "consent" and declined.look()["step"]["kind"] == "code"
    monkeypatch.setattr(server_participants, "MOST_UNDECIDED", 0)
    solo.look()
    assert all(visitor.look()["step"]["kind"] == "consent" for visitor in here), "their pages are open"


def test_one_page_that_changes_without_end_keeps_nobody_waiting(solo: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(solo.live.host, "admission", AdmissionControl(limits(study_changes_per_s=2.0), lambda: now[0]))
    restless, other = solo.visitor(), solo.visitor()
    spoken = [restless.call(f"view?lang={language}") for language in [*["de", "en"] * 10, *["de"] * 4]]
    assert [status for status, _ in spoken] == [200] * 20 + [429] * 4
    assert spoken[-1][1]["error"]["code"] == "too_many_requests"
    assert restless.call("view?lang=en")[0] == 200, "that is no change"
    assert [restless.call(path, body)[0] for path, body in (("next", {"key": "x"}), ("stop", {"keep": True}))] == [
        429
    ] * 2
    assert other.call("view?lang=de")[0] == 200 and restless.call("view")[0] == 200
    now[0] = 1.0
    assert [restless.call(f"view?lang={language}")[0] for language in ("de", "en", "de")] == [200, 200, 429]


def test_one_page_that_answers_without_end_does_not_keep_the_database_full(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    hasty, other = (solo.visitor().go_to("questionnaire") for _ in range(2))
    monkeypatch.setattr(solo.live.host, "admission", AdmissionControl(limits(study_answers_per_s=0.5), lambda: now[0]))
    told = [hasty.answer("teamwork", 1 + count % 7) for count in range(7)]
    assert [status for status, _ in told] == [200] * 5 + [429] * 2
    assert told[-1][1]["error"]["code"] == "too_many_requests"
    assert other.answer("teamwork", 3)[0] == 200
    now[0] = 2.0
    assert [hasty.answer("teamwork", 4)[0] for _ in range(2)] == [200, 429]


def test_unknown_tokens_from_one_address_are_looked_up_so_often(solo: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    few = AdmissionControl(limits(study_unknown_tokens_per_s=0.05), lambda: 0.0)
    monkeypatch.setattr(solo.live.host, "admission", few)
    visitor, replaced = solo.visitor(PROLIFIC_PID="tokens"), solo.visitor(PROLIFIC_PID="tokens")
    found = [solo.live.call("/api/study/view", token=f"wrong-{count}")[0] for count in range(8)]
    assert found == [401] * 5 + [429] * 3
    assert visitor.call("view")[0] == replaced.call("view")[0] == 200, "they are remembered"


def test_unknown_tokens_are_counted_where_somebody_arrives_with_them(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = AdmissionControl(limits(study_unknown_tokens_per_s=0.05), lambda: 0.0)
    monkeypatch.setattr(solo.live.host, "admission", few)
    looked_up: list[str] = []
    identities = solo.running.databases.identities
    monkeypatch.setattr(identities, "of_session", looked_up.append)
    visitor = solo.visitor()
    for _ in range(2):
        again = solo.arrive(beside=visitor.token, known=["wrong", visitor.token, "more"])[0]
        assert again == 200, "what is remembered costs nothing"
    told = [solo.arrive(beside="wrong", known=["wrong", "wrong"]) for _ in range(3)]
    assert [status for status, _ in told] == [200, 429, 429]
    assert told[-1][1]["error"]["code"] == "too_many_requests" and len(looked_up) == 5
    assert solo.arrive()[0] == 200, "who is new has no token"


def test_pages_that_were_replaced_are_remembered_up_to_a_number(solo: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_service, "MOST_SUPERSEDED", 2)
    pages = [solo.visitor(PROLIFIC_PID="again") for _ in range(4)]
    assert [page.call("view")[0] for page in pages[:1]] == [401], "it arrives again"
    assert [page.look()["step"]["kind"] for page in pages[1:]] == ["ended-elsewhere", "ended-elsewhere", "consent"]


def test_one_token_has_three_streams_and_the_newest_work(solo: Served) -> None:
    visitor = solo.visitor()
    request = urllib.request.Request(f"http://{solo.live.address}/api/study/events")
    request.add_header("Authorization", f"Bearer {visitor.token}")
    with contextlib.ExitStack() as stack:
        streams = []
        for _ in range(10):
            streams.append(stack.enter_context(urllib.request.urlopen(request, timeout=WAIT_S)))
            assert streams[-1].readline() == b": open\n"
        for stream in streams[:7]:
            assert stream.read() == b"\n", "it has ended"
        session = solo.running.participants[visitor.pid]
        assert len(session.listeners) == 3
        solo.live.run(lambda: notify([session]))
        for stream in streams[7:]:
            assert [stream.readline() for _ in range(2)][1] == b'data: {"changed":true}\n'


def test_answers_of_one_address_cannot_fill_the_disk(solo: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each participant may answer megabytes, and one address may send a thousand a minute."""
    visitor = solo.visitor().go_to("questionnaire")
    monkeypatch.setattr(
        solo.live.host, "admission", AdmissionControl(limits(answered_per_address_per_day=20_000.0), lambda: 0.0)
    )
    told = [visitor.answer("comment", -1, f"{number}" * 3000) for number in range(8)]
    assert [status for status, _ in told] == [200] * 6 + [429] * 2
    assert told[-1][1]["error"]["code"] == "too_many_requests"


def test_a_thousand_changes_of_a_text_leave_two_hundred_rows_and_the_last_text(solo: Served) -> None:
    visitor = solo.visitor().go_to("questionnaire")
    key = visitor.step["key"]
    for number in range(MOST_CHANGES + 40):
        assert visitor.answer("comment", -1, f"text {number}")[0] == 200
    assert visitor.answer("teamwork", 5)[0] == 200, "what was not answered yet still can be"
    mine = [
        row for row in solo.running.databases.store.rows(answers) if (row["pid"], row["step"]) == (visitor.pid, key)
    ]
    assert len(mine) == MOST_CHANGES + 1
    shown = visitor.look()["step"]["answers"]
    assert (shown["comment"]["text"], shown["teamwork"]["value"]) == (f"text {MOST_CHANGES + 39}", 5)


def test_who_knows_the_link_reads_no_text_that_was_written_on_another_device(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        victim = study.visitor(PROLIFIC_PID="victim").go_to("questionnaire")
        victim.answer("comment", -1, "I am Jane, and this was fun")
        victim.answer("teamwork", 6)
        study.ask("allow-device", pid=victim.pid)
        thief = study.visitor(PROLIFIC_PID="victim")
        assert thief.step["answers"] == {
            "comment": {"value": -1, "text": "", "hidden": True},
            "teamwork": {"value": 6, "text": ""},
        }
        thief.answer("comment", -1, "mine")
        assert thief.look()["step"]["answers"]["comment"] == {"value": -1, "text": "mine"}
        token = thief.token
    with served(tmp_path) as study:  # nor after a restart
        stored = study.running.databases.store
        key = thief.step["key"]
        with stored.database.write() as connection:
            connection.execute(answers.delete().where(answers.c.text == "mine"))
        assert "Jane" in stored.answers(Visitor(study, token, thief.view).pid, key)["comment"].text
        assert Visitor(study, token, thief.view).look()["step"]["answers"]["comment"]["text"] == ""


def test_the_link_opened_again_in_the_same_browser_shows_the_text(solo: Served) -> None:
    visitor = solo.visitor(PROLIFIC_PID="same-browser").go_to("questionnaire")
    visitor.answer("comment", -1, "my own words")
    body = {"parameters": {"PROLIFIC_PID": "same-browser"}, "language": "en", "known": [visitor.token]}
    status, answer = solo.live.call("/api/study/arrive", body)
    assert status == 200
    assert answer["view"]["step"]["answers"]["comment"] == {"value": -1, "text": "my own words"}


def test_codes_have_forty_bits_at_least(solo: Served) -> None:
    assert len(set(UNMISTAKABLE)) ** CODE_LENGTH >= 2**40
    made = [str(solo.ask("open-next")["code"]) for _ in range(100)]
    assert all(len(code) == 8 for code in made) and len(set("".join(made))) == 32, "5 bits a letter"


# ---- a database that somebody else holds --------------------------------------------------------------------------


def test_a_locked_database_refuses_all_at_once_and_in_a_sentence(tmp_path: Path) -> None:
    """Twenty answers that wait one after the other would be refused after 20 waits."""
    waits: list[float] = []
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("form")
        databases = study.running.databases
        answer = databases.store.answer

        def counted(**row: Any) -> None:
            waits.append(0.0)
            answer(**row)

        databases.store.answer = counted  # type: ignore[method-assign, assignment]
        with contextlib.closing(sqlite3.connect(study.folder.own / "study.sqlite")) as other:
            other.execute("BEGIN IMMEDIATE")
            with ThreadPoolExecutor(20) as pool:
                told = list(pool.map(lambda _: visitor.answer("age", 1), range(20)))
            assert {(status, body["error"]["code"]) for status, body in told} == {(507, "not_saved")}
            assert len(waits) < 10, "the others did not wait again"
            other.rollback()
        assert visitor.answer("age", 1)[0] == 200


def test_a_game_of_a_study_keeps_no_answers_beside_the_study(solo: Served) -> None:
    visitor = solo.visitor().go_to("round")
    visitor.next()
    room = visitor.step["room"]
    body = {"question": "comment", "value": -1, "text": "I am Jane"}
    status, told = solo.live.call(f"/api/rooms/{room['id']}/answers", body, room["token"])
    assert (status, told["error"]["code"]) == (409, "study")
    assert list((solo.folder.data / "answers").glob("*")) == []


# ---- the experimenter's page with thousands of people -------------------------------------------------------------


def test_the_dashboard_of_three_thousand_sends_what_has_changed_in_small_documents(solo: Served) -> None:
    running = solo.running
    visitor = solo.visitor().go_to("form")
    sample = running.participants[visitor.pid]

    def crowd() -> Participants:
        many = Participants(running.study, running.databases)
        for number in range(3000):
            outcome = "done" if number >= 10 else None
            record = replace(sample.record, pid=f"X{number}", outcome=outcome, code="CODE" if outcome else None)
            many._add(record, "link")
        return many

    async def watched() -> tuple[list[str], list[str]]:
        dashboard = Dashboard(running, ParticipantViews(running))
        running.participants, real = crowd(), running.participants
        try:
            await dashboard.refresh()
            whole = list(dashboard.news(-1))
            seen, dashboard._made_at = dashboard.version, -1.0
            await dashboard.refresh()
            return whole, list(dashboard.news(seen))
        finally:
            running.participants = real

    whole, later = asyncio.run_coroutine_threadsafe(watched(), solo.live.loop).result(WAIT_S)
    assert len(whole) == 15 and max(len(document) for document in whole) < 150_000
    assert sum(len(json.loads(document).get("more", [])) for document in whole[1:]) == 2800
    assert not json.loads(whole[0])["partial"] and json.loads(later[0])["partial"]
    assert len(later) == 1 and len(json.loads(later[0])["participants"]) <= 10, "who has finished does not change"


def test_the_live_stream_begins_with_everybody_and_goes_on_with_changes(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    request = urllib.request.Request(f"http://{solo.live.address}/api/experimenter/live")
    request.add_header("Authorization", f"Bearer {ADMIN}")
    with urllib.request.urlopen(request, timeout=WAIT_S) as stream:
        first = json.loads(stream.readline()[6:])
        assert visitor.pid in [row["pid"] for row in first["participants"]] and not first["partial"]
        visitor.stop(keep=True)
        while True:
            line = stream.readline()
            changed = json.loads(line[6:])["participants"] if line.startswith(b"data: ") else []
            if any(row["pid"] == visitor.pid and row["outcome"] for row in changed):
                break
