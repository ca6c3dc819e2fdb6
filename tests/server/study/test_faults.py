"""Database errors, a full disk, a failing room: each gives a sentence and an alert, and nothing is lost."""

import asyncio
import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pytest

from movingout.agents.errors import AgentError, AgentsBusyError
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.notices import Notice
from movingout.server.rooms.seat import Seat
from movingout.server.study import databases
from movingout.study.errors import StoreError
from movingout.study.store.tables import answers, rounds
from tests.recordings.full_disk import limited
from tests.server.live import raw_socket
from tests.server.study.support import SOLO, Served, Visitor, served

pytestmark = pytest.mark.slow

LONG = SOLO.replace("[HandOff], limit_ticks: 20", "[HandOff], limit_ticks: 60")


@pytest.fixture(scope="module")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("faults"), LONG) as running:
        yield running


@pytest.fixture
def study(serving: Served) -> Iterator[Served]:
    serving.running.alerts._alerts = []
    yield serving
    serving.live.hang_up()


def rounds_of(study: Served, visitor: Visitor) -> list[str]:
    """The outcomes of somebody's rounds."""
    unit = study.running.participants[visitor.pid].record.unit
    return [row["outcome"] for row in study.running.databases.store.rows(rounds) if row["unit"] == unit]


def pragma(study: Served, sentence: str) -> None:
    with study.running.databases.store.database.write() as connection:
        connection.exec_driver_sql(sentence)


@contextmanager
def read_only(study: Served) -> Iterator[None]:
    """Nothing can be written for a while."""
    pragma(study, "PRAGMA query_only=ON")
    try:
        yield
    finally:
        with study.running.databases.store.database.read() as connection:
            connection.exec_driver_sql("PRAGMA query_only=OFF")


def test_a_read_only_database_is_a_sentence_and_an_alert_and_what_is_tried_again_arrives(study: Served) -> None:
    visitor = study.visitor().go_to("form")
    for item in visitor.step["items"]:
        visitor.answer(item["id"])
    with read_only(study):
        status, answer = visitor.answer("age", 1)
        assert (status, answer["error"]["code"]) == (507, "not_saved")
        assert "/" not in answer["error"]["message"], "participants need no paths"
        status, answer = visitor.call("next", {"key": "form"})
        assert (status, answer["error"]["code"]) == (507, "not_saved")
        assert visitor.look()["step"]["kind"] == "form"
    (alert,) = [one for one in study.state()["alerts"] if one["about"] == "database"]
    assert "readonly database; make the file and its folder writable" in alert["text"]
    assert visitor.answer("age", 1)[0] == 200
    assert visitor.next()["step"]["kind"] == "input-check"
    kept = [row for row in study.running.databases.store.rows(answers) if row["pid"] == visitor.pid]
    assert len(kept) == 8


def test_who_is_here_need_not_be_noted_for_a_study_to_go_on(study: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    def locked(*_: object) -> None:
        raise StoreError("database is locked")

    visitor = study.visitor().go_to("form")
    study.ask("pause")
    monkeypatch.setattr(study.running.databases.store, "seen", locked)
    study.ask("resume")
    assert visitor.look()["step"]["kind"] == "form"


def test_the_end_of_a_round_waits_for_the_database(study: Served) -> None:
    visitor = study.visitor().go_to("round")
    visitor.next()
    person = visitor.player()
    person.next_tick(visitor.step["room"]["seat"])
    with read_only(study):
        person.play_out(visitor.step["room"]["seat"])
        visitor.wait_until(lambda one: one.step["state"] == "over")
        assert visitor.next()["step"]["state"] == "over", "and nobody is sent on before it is saved"
    study.look()
    assert visitor.look()["step"]["kind"] == "questionnaire"
    assert rounds_of(study, visitor) == ["time"]


def test_a_round_that_cannot_be_written_down_does_not_begin_until_it_can(study: Served) -> None:
    visitor = study.visitor().go_to("round")
    with read_only(study):
        visitor.next()
        assert (visitor.step["state"], visitor.step["room"]) == ("waiting", None)
        aliases = [room.seats[0].alias for room in study.live.rooms if not room.config.practice]
        assert visitor.pid not in aliases
    assert "room" in study.alerts()
    study.look()
    visitor.look()
    assert visitor.step["state"] == "playing" and "room" not in study.alerts(), "it can play by now"
    visitor.play()
    assert visitor.kind == "questionnaire"


def test_a_full_database_keeps_what_was_confirmed(study: Served) -> None:
    visitor = study.visitor().go_to("questionnaire")
    with study.running.databases.store.database.read() as connection:
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar_one()
    pragma(study, f"PRAGMA max_page_count={pages + 20}")
    statuses = [visitor.answer("comment", -1, f"x{number}" + "x" * 3900)[0] for number in range(60)]
    assert set(statuses) == {200, 507}
    kept = [
        row for row in study.running.databases.store.rows(answers) if row["item"] == "comment" and row["text"][0] == "x"
    ]
    assert len(kept) == statuses.count(200)
    assert "database" in study.alerts()
    pragma(study, "PRAGMA max_page_count=1000000")
    assert visitor.answer("comment", -1, "at last")[0] == 200


def test_wherever_the_disk_is_full_an_answer_is_kept_or_refused_and_later_taken(study: Served) -> None:
    visitor, said = study.visitor().go_to("questionnaire"), []
    for size in (0, 1, 30, 1_000, 4_000, 5_000, 10_000, 20_000, 40_000):
        for number in range(6):
            said.append(f"{size}-{number}" + "y" * 2_000)
            with limited(size):
                status, answer = visitor.answer("comment", -1, said[-1])
            if status != 200:
                assert (status, answer["error"]["code"]) == (507, "not_saved")
                assert "Nothing that was saved is lost" in answer["error"]["message"]
                refused, _ = visitor.answer("comment", -1, said[-1])  # as the page does, and there is room
                assert refused == 200
    kept = [row["text"] for row in study.running.databases.store.rows(answers) if row["text"].endswith("yyy")]
    assert kept == said, "each once"
    assert "database" in study.alerts()


@pytest.mark.parametrize(
    ("asked", "answer", "alerts"),
    [
        ("full_disk", Notice("disk_full", "The disk is full."), {"room", "disk"}),
        ("process_health", ProcessHealth(agents=True, unwritable="writing: Read-only file system"), {"room"}),
    ],
)
def test_a_disk_that_is_full_or_takes_no_writing_lets_no_round_begin_and_says_so(
    study: Served, monkeypatch: pytest.MonkeyPatch, asked: str, answer: object, alerts: set[str]
) -> None:
    visitor = study.visitor().go_to("round")
    monkeypatch.setattr(study.live.host, asked, lambda: answer)
    visitor.next()
    assert visitor.step["state"] == "waiting"
    study.look()
    assert alerts <= set(study.alerts())
    monkeypatch.undo()
    study.look()
    assert visitor.look()["step"]["state"] == "playing"


def test_while_the_data_folder_is_away_the_experimenter_reads_why(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(folder: Path) -> NoReturn:
        raise FileNotFoundError(folder)

    monkeypatch.setattr(shutil, "disk_usage", gone)
    study.look()
    state = study.state()
    assert state["server"]["disk_free_mb"] == 0 and state["alerts"][0]["about"] == "disk"


def test_an_alert_says_no_more_than_the_letter_of_an_agent_that_has_no_room(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def full(*_: object) -> str:
        raise AgentsBusyError("no room for one more 'idle': the agents of this server are all at work")

    visitor = study.visitor().go_to("round")
    monkeypatch.setattr(study.live.host, "open_room", full)
    visitor.next()
    alert = next(one for one in study.running.alerts.to_json() if one["about"] == "room")
    letter = f"Partner {visitor.step['partner_letter']}"
    assert alert["detail"] == f"no room for one more {letter}: the agents of this server are all at work"
    assert "idle" not in str(alert)


def test_an_alert_does_not_name_the_file_of_an_agent_that_is_gone_and_the_log_does(
    study: Served, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def gone(*_: object) -> str:
        raise AgentError("there is no /share/dp-best.onnx")

    visitor = study.visitor().go_to("round")
    monkeypatch.setattr(study.live.host, "open_room", gone)
    visitor.next()
    alert = next(one for one in study.running.alerts.to_json() if one["about"] == "room")
    letter = f"Partner {visitor.step['partner_letter']}"
    assert alert["detail"] == f"{letter} cannot be loaded; the server's log has the reason"
    assert "there is no /share/dp-best.onnx" in caplog.text


def test_a_room_that_fails_is_opened_again(study: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    visitor = study.visitor().go_to("round")
    visitor.next()
    visitor.player().next_tick(visitor.step["room"]["seat"])
    room = study.live.host.registry.rooms[visitor.step["room"]["id"]]

    def fail(*_: Any) -> None:
        raise ZeroDivisionError("a fault in the room")

    monkeypatch.setattr(room, "_step", fail)
    visitor.wait_until(lambda one: one.step["state"] == "card")
    visitor.play()
    assert visitor.kind == "questionnaire"
    assert rounds_of(study, visitor) == ["error", "time"]


def test_whoever_comes_when_too_many_queries_wait_is_told_at_once_to_try_again(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(databases, "MOST_WAITING", 3)
    visitor = study.visitor().go_to("form")
    stuck, run = threading.Event(), study.running.databases.run
    waiting = [asyncio.run_coroutine_threadsafe(run(stuck.wait, 60), study.live.loop) for _ in range(3)]
    try:
        begun = time.monotonic()
        status, answer = visitor.answer(visitor.step["items"][0]["id"], 1)
        assert (status, answer["error"]["code"]) == (507, "not_saved")
        assert time.monotonic() - begun < 20.0
        assert "database" in study.alerts()
    finally:
        stuck.set()
    assert all(one.result(20) for one in waiting)
    for item in visitor.step["items"]:
        assert visitor.answer(item["id"])[0] == 200, "nothing is lost: the same again is taken"


def test_a_fault_in_the_server_is_a_sentence_and_not_a_stack_trace(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    visitor = study.visitor()
    monkeypatch.setattr(study.running.progress, "is_paused", lambda session: 1 / 0)
    status, answer = visitor.call("view")
    assert (status, answer["error"]["code"]) == (500, "fault")
    assert "Traceback" not in str(answer) and "Division" not in str(answer)
    assert "fault" in study.alerts()


def test_a_request_that_breaks_off_is_no_fault_of_the_server(solo: Served, caplog: pytest.LogCaptureFixture) -> None:
    """A phone that lost its network, or anybody on purpose, alarmed the experimenter and wrote a traceback."""
    before, head = solo.alerts(), b"HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n{"
    for path in (b"/api/study/arrive", b"/api/rooms"):
        with raw_socket(solo.live) as client:
            client.sendall(b"POST " + path + b" " + head)
            time.sleep(0.2)  # the handler waits for the rest
    assert solo.arrive()[0] == 200
    time.sleep(0.2)
    assert solo.alerts() == before
    errors = [record for record in caplog.records if record.levelname == "ERROR"]
    made = [one for one in errors if one.exc_info and one.exc_info[0] is ZeroDivisionError]  # by the test before
    assert [one.getMessage() for one in errors if one not in made] == []


def test_what_is_no_request_is_told_what_is_wrong(solo: Served) -> None:
    visitor = solo.visitor()
    for path, body in (("next", {}), ("next", {"key": 7}), ("answer", {"key": "form"}), ("stop", {"keep": "yes"})):
        status, answer = visitor.call(path, body)
        assert (status, answer["error"]["code"]) == (422, "bad_request"), path
    status, answer = solo.arrive(PROLIFIC_PID="x" * 300)
    assert (status, answer["error"]["code"]) == (403, "link")


def test_an_alert_about_a_partner_names_the_letter_and_not_the_agent(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = property(lambda seat: "" if seat.alias else "bass@all cannot play on this map.")
    monkeypatch.setattr(Seat, "agent_failure", told)
    monkeypatch.setattr(Seat, "agent_caution", told)
    visitor = study.visitor().go_to("round")
    visitor.next()
    study.look()
    alerts = [one for one in study.state()["alerts"] if one["about"].startswith("agent_")]
    assert {one["about"] for one in alerts} == {"agent_failed", "agent_unseen"}
    assert {one["values"]["partner"] for one in alerts} <= {"Partner", "Partner A", "Partner B"}, "or in practice"
    assert "bass" not in str(alerts)


def test_a_problem_of_a_round_is_told_once_and_shown_until_it_is_over(
    study: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They came again every minute, also after the experimenter had dismissed them, and were never taken back."""
    monkeypatch.setattr("movingout.server.study.alerts.REPEAT_S", 0.0)
    visitor = study.visitor().go_to("round")
    visitor.next()
    unit = study.running.units.of(study.running.participants[visitor.pid])
    assert unit is not None and unit.running_round is not None
    before = unit.running_round.view
    playing = before._replace(phase="playing", recording=True)
    failing = tuple(seat._replace(agent_failure="ZeroDivisionError") for seat in playing.seats)

    def shown(**changes: Any) -> list[str]:
        """The alerts after two looks at a round like this."""
        assert unit is not None and unit.running_round is not None
        unit.running_round.view = playing._replace(**changes)
        for _ in range(2):
            study.monitor._notice_room(unit)
        alerts = study.running.alerts.to_json()
        return sorted(one["about"] for one in alerts if one["values"].get("unit") == unit.record.id)

    def looks() -> list[list[str]]:
        return [
            shown(seats=failing, recording=False),
            shown(recording=False),
            shown(phase="lobby", recording=False, episode="next"),  # that a round has no recording stays true …
            shown(recording=False, episode="next"),
            shown(episode="third"),  # … and is no news once another one has
            shown(phase=before.phase, episode=before.episode),
        ]

    failed = ["agent_failed"] * len(failing)
    assert study.live.run(looks) == [[*failed, "recording"], ["recording"], ["recording"], ["recording"] * 2, [], []]
