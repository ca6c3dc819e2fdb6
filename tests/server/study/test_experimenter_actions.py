"""The experimenter's page: its state and its actions, which need the admin token."""

import asyncio
import codecs
import csv
import io
import json
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map, map_to_json
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.notes import ExperimenterNotes
from movingout.study.store.removal import remove_participant
from movingout.study.store.tables import audit, notes, rounds
from tests.server.cluster.processes import wait_until
from tests.server.live import ADMIN, WAIT_S
from tests.server.study.support import SOLO, Served, Visitor, served

LONG = SOLO.replace("[HandOff], limit_ticks: 20", "[HandOff], limit_ticks: 400")


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A study whose rounds last 2 s, long enough to act on them."""
    with served(tmp_path_factory.mktemp("long"), LONG) as running:
        yield running
        running.live.hang_up()


def playing(study: Served) -> Visitor:
    """Somebody in the middle of a round."""
    visitor = study.visitor().go_to("round")
    visitor.next()
    visitor.player().next_tick(visitor.step["room"]["seat"])
    return visitor


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "state"), ("GET", "live"), ("GET", "payments.csv"), ("GET", "qr.svg?code=A"), ("POST", "pause"),
        ("POST", "resume"), ("POST", "restart-round"), ("POST", "kick"), ("POST", "invalid"), ("POST", "valid"),
        ("POST", "note"), ("POST", "open-next"), ("POST", "next-code"),
    ],
)  # fmt: skip
def test_nothing_is_told_or_done_without_the_token(solo: Served, method: str, path: str) -> None:
    body: dict[str, str] | None = {} if method == "POST" else None
    for token, status in (("", 401), ("made-up", 403)):
        assert solo.live.call(f"/api/experimenter/{path}", body, token)[0] == status


def test_a_participants_secret_opens_no_door_of_the_experimenter(solo: Served) -> None:
    assert solo.live.call("/api/experimenter/state", token=solo.visitor().token)[0] == 403


def test_the_screen_shows_who_is_where(long: Served) -> None:
    visitor = playing(long)
    row = long.row(visitor.pid)
    assert {name: row[name] for name in ("kind", "round", "phase", "limit_ticks", "recording", "outcome")} == {
        "kind": "round", "round": {"number": 1, "of": 2}, "phase": "playing", "limit_ticks": 400,
        "recording": "recording", "outcome": None,
    }  # fmt: skip
    assert row["room"] == visitor.step["room"]["id"] and row["tick"] > 0 and row["late_ms"] is not None
    assert (row["partner_letter"], row["present"], row["paused"]) == (visitor.step["partner_letter"], True, False)
    assert (row["map"], row["title"]) == ("HandOff", "Hand Off") and row["episode"]
    visitor.stop(True)
    row = long.row(visitor.pid)
    assert (row["kind"], row["outcome"], row["code_given"], row["room"]) == ("code", "withdrew", True, None)
    state = long.state()
    titles = {"en": "StudyRooms with partners", "de": "Mit Partnern spielen"}
    assert state["study"] == {"id": "solo", "title": titles["en"], "titles": titles}
    assert state["counts"]["planned"] == 400
    assert state["server"]["ticks"] > 0 and state["server"]["disk_free_mb"] > 0


def test_the_screen_is_told_once_a_second(solo: Served) -> None:
    request = urllib.request.Request(f"http://{solo.live.address}/api/experimenter/live")
    request.add_header("Authorization", f"Bearer {ADMIN}")
    with urllib.request.urlopen(request, timeout=WAIT_S) as stream:
        told = [json.loads(line[6:]) for _ in range(4) if (line := stream.readline()).startswith(b"data: ")]
    assert [state["study"]["id"] for state in told] == ["solo", "solo"]


def test_a_pause_between_rounds_is_seen_and_is_no_time_at_the_step(solo: Served) -> None:
    visitor = solo.visitor().go_to("round")
    session = solo.running.participants[visitor.pid]
    session.step_since -= 30
    assert (solo.row(visitor.pid)["since_s"], solo.row(visitor.pid)["paused_s"]) == (30, None)
    solo.ask("pause", pid=visitor.pid)
    unit = solo.running.units.of(session)
    assert unit is not None and unit.standing_since is not None
    unit.standing_since -= 10
    session.step_since -= 10
    row = solo.row(visitor.pid)
    assert (row["room"], row["paused"], row["unit_paused"]) == (None, True, True)
    assert (row["since_s"], row["paused_s"]) == (30, 10)
    solo.ask("resume", pid=visitor.pid)
    row = solo.row(visitor.pid)
    assert (row["since_s"], row["paused_s"], row["unit_paused"]) == (30, None, False)


def test_the_end_of_a_pause_makes_nobody_present_and_begins_their_absence_anew(solo: Served) -> None:
    visitor = solo.visitor().go_to("practice")

    def told() -> bool:
        solo.look()
        return visitor.pid in [one["values"].get("pid") for one in solo.running.alerts.to_json()]

    solo.ask("pause")
    solo.later(600)
    solo.ask("resume")
    assert not solo.row(visitor.pid)["present"], "their page was closed in the pause"
    assert not told()
    solo.later(121)
    assert told()


def test_whoever_was_here_and_is_away_for_two_minutes_is_told_of_once(solo: Served) -> None:
    visitor = solo.visitor().go_to("practice")
    session = solo.running.participants[visitor.pid]

    def told() -> list[str]:
        solo.look()
        return [one["values"]["pid"] for one in solo.running.alerts.to_json() if one["about"] == "away"]

    assert visitor.pid not in told()
    session.last_seen_at -= 121
    assert told().count(visitor.pid) == 1 and told().count(visitor.pid) == 1
    visitor.look()
    assert told().count(visitor.pid) == 1
    solo.running.alerts._alerts = []  # as if a minute had gone by
    session.last_seen_at -= 121
    assert told().count(visitor.pid) == 1


@pytest.mark.parametrize("reached", ["consent", "input-check"])
def test_who_opens_the_link_and_leaves_before_the_game_is_no_alert(solo: Served, reached: str) -> None:
    """Alerts of many strangers would push others off the page."""
    visitor = solo.visitor().go_to(reached)
    solo.later(121)
    solo.look()
    assert visitor.pid not in [one["values"].get("pid") for one in solo.running.alerts.to_json()]
    assert not solo.row(visitor.pid)["present"]


def test_a_row_of_somebody_who_has_finished_has_code_and_minutes(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    assert (solo.row(visitor.pid)["code"], solo.row(visitor.pid)["minutes"]) == (None, None)
    visitor.stop(True)
    row = solo.row(visitor.pid)
    assert row["code"] == visitor.step["code"] and 0 <= row["minutes"] < 5


def test_a_paused_round_stands_still_until_the_experimenter_lets_it_go_on(long: Served) -> None:
    visitor = playing(long)
    long.ask("pause", pid=visitor.pid)
    assert visitor.look()["step"]["kind"] == "paused"
    assert visitor.next()["step"]["kind"] == "paused"
    row = long.row(visitor.pid)
    assert (row["phase"], row["paused"]) == ("paused", True)
    assert long.row(visitor.pid)["tick"] == row["tick"]
    other = long.visitor()
    other.agree()
    assert other.kind == "form", "the others go on"
    long.ask("resume", pid=visitor.pid)
    assert visitor.look()["step"]["state"] == "playing"
    visitor.wait_until(lambda one: long.row(one.pid)["phase"] == "playing")


def test_when_all_are_paused_everybody_sees_it(long: Served) -> None:
    visitor, newcomer = playing(long), long.visitor()
    long.ask("pause")
    assert visitor.look()["step"]["kind"] == newcomer.look()["step"]["kind"] == "paused"
    assert long.visitor().kind == "paused"
    assert long.row(visitor.pid)["phase"] == "paused"
    long.ask("resume")
    newcomer.look()
    newcomer.agree()
    assert newcomer.kind == "form"


def test_a_restarted_round_is_played_again_from_its_card(long: Served) -> None:
    visitor = playing(long)
    key = visitor.step["key"]
    long.ask("restart-round", pid=visitor.pid, reason="the phone rang")
    assert (visitor.look()["step"]["key"], visitor.step["state"]) == (key, "card")
    visitor.next()
    visitor.player().next_tick(visitor.step["room"]["seat"])
    unit = long.running.participants[visitor.pid].record.unit
    mine = [row for row in long.running.databases.store.rows(rounds) if row["unit"] == unit]
    assert [(row["attempt"], row["outcome"]) for row in mine] == [(1, "stopped"), (2, None)]
    assert len({row["episode"] for row in mine}) == 2


def test_the_last_round_is_marked_invalid_while_the_next_one_runs_and_may_count_again(long: Served) -> None:
    visitor = long.visitor().go_to("round")
    assert long.row(visitor.pid)["last_round"] is None
    visitor.go_to("questionnaire").go_to("round")
    visitor.next()
    visitor.player().next_tick(visitor.step["room"]["seat"])
    row = long.row(visitor.pid)
    last = row["last_round"]
    assert {**last, "episode": ""} == {"episode": "", "number": 1, "map": "HandOff", "title": "Hand Off", "valid": True}

    def valid() -> dict[str, bool]:
        mine = [one for one in long.running.databases.store.rows(rounds) if one["unit"] == row["unit"]]
        return {one["episode"]: one["valid"] for one in mine}

    long.ask("invalid", pid=visitor.pid, reason="somebody helped")
    assert valid() == {last["episode"]: False, row["episode"]: True}, "not the one that runs: that is restarted"
    assert not long.row(visitor.pid)["last_round"]["valid"]
    long.ask("valid", episode=last["episode"], reason="nobody did")
    assert valid() == {last["episode"]: True, row["episode"]: True}
    assert long.row(visitor.pid)["last_round"]["valid"]
    assert "valid: nobody did" in [note["text"] for note in long.running.databases.store.rows(notes)]
    assert "invalid: somebody helped" in [note["text"] for note in long.running.databases.store.rows(notes)]
    assert "somebody helped" not in str(long.running.databases.store.rows(audit)), "nothing can be deleted there"
    status, answer = long.live.call("/api/experimenter/invalid", {"episode": "none"}, ADMIN)
    assert (status, answer["error"]["message"]) == (409, "there is no round with the recording 'none'")


def test_the_last_round_can_be_marked_after_the_end_and_the_page_says_so(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("code")
        study.look()
        assert study.running.units.of(study.running.participants[visitor.pid]) is None

        def shown() -> dict[str, Any]:
            dashboard._made_at = -1.0  # as if a second had passed
            asyncio.run_coroutine_threadsafe(dashboard.refresh(), study.live.loop).result(WAIT_S)
            return dict(dashboard._rows[visitor.pid]["last_round"])

        dashboard = Dashboard(study.running, ParticipantViews(study.running))
        assert (shown()["number"], shown()["valid"]) == (2, True)
        study.ask("invalid", pid=visitor.pid, reason="somebody helped")
        assert not shown()["valid"]
        study.ask("valid", episode=shown()["episode"], reason="nobody did")
        assert shown()["valid"]
        study.live.hang_up()
    with served(tmp_path) as study:
        assert study.row(study.state()["participants"][0]["pid"])["last_round"]["number"] == 2, (
            "after a restart as well"
        )


def test_a_deleted_round_can_be_marked_no_more(solo: Served) -> None:
    visitor = solo.visitor().go_to("questionnaire")
    assert solo.row(visitor.pid)["last_round"]
    recorded, left = solo.running.rooms.finished, solo.running.rooms.finished.left
    visitor.stop(keep=False)
    assert solo.row(visitor.pid)["kept"] is False
    wait_until(lambda: solo.row(visitor.pid)["last_round"] is None, "the deletion")
    assert recorded.left == left - 1


def test_a_map_beside_the_study_file_is_shown_from_any_folder_also_when_its_file_has_moved(tmp_path: Path) -> None:
    den = replace(load_map("HandOff"), name="Den", title="The Den")
    file = tmp_path / "den.json"
    file.write_text(json.dumps(map_to_json(den)), encoding="utf-8")
    with served(tmp_path / "data", SOLO.replace("[HandOff]", "[den.json]"), beside=tmp_path) as study:
        file.rename(tmp_path / "moved.json")
        visitor = study.visitor().go_to("questionnaire")
        (row,) = [row for row in study.state()["participants"] if row["pid"] == visitor.pid]
        assert (row["last_round"]["map"], row["last_round"]["title"]) == ("Den", "The Den")
        study.live.hang_up()


@pytest.mark.parametrize(
    ("action", "order", "status"),
    [
        ("pause", {"unit": 10**12}, 409), ("pause", {"pid": "PXXXXXX", "reason": "why not"}, 409),
        ("pause", {"unit": "first"}, 422), ("pause", {"unit": 10**40}, 409), ("resume", {"unit": -1}, 409),
        ("note", {"text": "about nobody", "unit": 10**12}, 409), ("note", {"text": 5}, 422), ("invalid", {}, 409),
        ("restart-round", {}, 409), ("kick", {"pid": ""}, 409), ("open-next", [], 422),
    ],
)  # fmt: skip
def test_an_order_about_nobody_is_refused_and_leaves_no_trace(
    solo: Served, action: str, order: object, status: int
) -> None:
    before = [len(solo.running.databases.store.rows(table)) for table in (audit, notes)]
    found, answer = solo.live.call(f"/api/experimenter/{action}", order, ADMIN)
    assert (found, bool(answer["error"]["message"])) == (status, True)
    assert [len(solo.running.databases.store.rows(table)) for table in (audit, notes)] == before
    assert "database" not in solo.alerts() and not solo.running.progress.paused


def test_a_round_that_was_never_played_cannot_be_marked(solo: Served) -> None:
    visitor = solo.visitor().go_to("practice")
    status, answer = solo.live.call("/api/experimenter/invalid", {"pid": visitor.pid}, ADMIN)
    assert (status, answer["error"]["message"]) == (409, "they have not finished a round yet")


def test_who_is_kicked_gets_a_code(long: Served) -> None:
    visitor = playing(long)
    long.ask("kick", pid=visitor.pid, reason="fell asleep")
    assert (visitor.look()["step"]["kind"], bool(visitor.step["code"])) == ("code", True)
    actions = [row["action"] for row in long.running.databases.store.rows(audit)]
    assert "kick" in actions
    assert visitor.pid not in str(long.running.databases.store.rows(audit))
    for action in ("kick", "restart-round", "pause"):
        assert long.live.call(f"/api/experimenter/{action}", {"pid": "PXXXXXX"}, ADMIN)[0] == 409


def test_who_is_ended_while_away_did_not_come_back_and_is_paid_until_then(long: Served) -> None:
    visitor = long.visitor().go_to("form")
    long.later(86_400)
    long.ask("kick", pid=visitor.pid)
    row = long.row(visitor.pid)
    assert (row["outcome"], row["minutes"] < 5) == ("dropped-out", True)


def test_a_note_on_somebody_without_a_unit_says_so_after_a_restart_and_goes_with_their_data(solo: Served) -> None:
    visitor = solo.visitor()
    visitor.agree()
    solo.ask("note", text="Fainted.", pid=visitor.pid)
    databases = solo.running.databases
    again = ExperimenterNotes(databases, solo.running.participants)
    asyncio.run_coroutine_threadsafe(again.restore(), solo.live.loop).result(WAIT_S)
    newest = again.to_json()[0]
    assert (newest["text"], newest["pid"]) == ("Fainted.", visitor.pid)
    remove_participant(databases.store, visitor.pid, 0)
    assert "Fainted" not in str(databases.store.rows(notes))


def test_notes_stay(solo: Served) -> None:
    visitor = solo.visitor().go_to("practice")
    solo.ask("note", text="  The light went out. ")
    solo.ask("note", text="Wears glasses.", pid=visitor.pid)
    notes = solo.running.notes.to_json()[:2]
    assert [(note["text"], note["pid"]) for note in notes] == [
        ("Wears glasses.", visitor.pid), ("The light went out.", None),
    ]  # fmt: skip
    assert solo.live.call("/api/experimenter/note", {"text": " "}, ADMIN)[0] == 409


@pytest.mark.slow
def test_the_next_participant_gets_a_link_with_a_picture(solo: Served) -> None:
    told = solo.ask("open-next")
    assert told["path"] == f"/study?code={told['code']}"
    status, picture = solo.live.call(f"/api/experimenter/qr.svg?code={told['code']}", token=ADMIN)
    assert status == 200 and b"<svg" in picture
    assert solo.visitor(code=told["code"]).kind == "consent"


def test_payments_name_the_assignment_that_was_taken_last(solo: Served) -> None:
    solo.visitor(workerId="WORKER", assignmentId="A1", hitId="H1")
    visitor = solo.visitor(workerId="WORKER", assignmentId="A2", hitId="H2").go_to("form")
    visitor.stop(True)
    solo.visitor(known=[visitor.token], workerId="WORKER", assignmentId="A3")
    prolific = solo.visitor(PROLIFIC_PID="member", SESSION_ID="=S", STUDY_ID="T").go_to("form")
    prolific.stop(True)
    _, text = solo.live.call("/api/experimenter/payments.csv", token=ADMIN)
    rows = {row["id"]: row for row in csv.DictReader(io.StringIO(text.decode("utf-8-sig")))}
    found = {id: (rows[id]["assignment"], rows[id]["task"]) for id in ("WORKER", "member")}
    assert found == {"WORKER": ("A2", "H2"), "member": ("'=S", "T")}


def test_payments_name_the_assignment_of_who_came_once_with_a_code(tmp_path: Path) -> None:
    with served(tmp_path, codes=True) as study:
        code = study.ask("open-next")["code"]
        study.visitor(code=code, workerId="WORKER", assignmentId="A1", hitId="H1").go_to("form").stop(True)
        _, text = study.live.call("/api/experimenter/payments.csv", token=ADMIN)
    (row,) = csv.DictReader(io.StringIO(text.decode("utf-8-sig")))
    assert (row["id"], row["assignment"], row["task"]) == (code, "A1", "H1")


@pytest.mark.slow
def test_payments_say_who_is_paid_what(solo: Served) -> None:
    visitor = solo.visitor(PROLIFIC_PID="=to-be-paid")
    visitor.agree()
    visitor.stop(True)
    status, text = solo.live.call("/api/experimenter/payments.csv", token=ADMIN)
    rows = list(csv.DictReader(io.StringIO(text.decode("utf-8-sig"))))
    (row,) = [row for row in rows if row["pid"] == visitor.pid]
    assert text.startswith(codecs.BOM_UTF8), "else Excel shows other letters for umlauts"
    assert status == 200 and row["code"] == visitor.step["code"]
    assert (row["source"], row["id"], row["outcome"], row["currency"]) == (
        "prolific",
        "'=to-be-paid",
        "withdrew",
        "USD",
    )
    assert row["data_kept"] == "True"
