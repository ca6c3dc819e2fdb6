"""A server that is killed or stopped in a study: everybody continues where they were, no round is lost or repeated."""

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from movingout.recordings import verify
from movingout.recordings.storage.index import list_recordings
from movingout.server.persistence.data_folder import told_interrupted, told_of_other_studies
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StoreError, StudyError
from movingout.study.store.tables import answers, audit, participants, players, rounds
from tests.server.persistence.test_room_snapshot import free_port
from tests.server.study.study_process import study_process
from tests.server.study.support import SOLO, Served, Visitor, served

LONG = SOLO.replace("[HandOff], limit_ticks: 20", "[HandOff], limit_ticks: 120")


def rows_of(data: Path, text: str, table: Any) -> list[dict[str, Any]]:
    store = StudyFolder(parse_study(text), data).open()
    try:
        return store.rows(table)
    finally:
        store.close()


@pytest.mark.slow
def test_after_kill_9_everybody_is_where_they_were_and_the_round_goes_on(tmp_path: Path) -> None:
    file, port = tmp_path / "study.yaml", free_port()
    file.write_text(LONG, encoding="utf-8")
    with study_process(file, tmp_path, port, "--rehearse", "5") as running:
        study: Any = running
        asking = _visitor(study, "asking").go_to("form")
        asking.answer("age", 2)
        player = _visitor(study, "playing").go_to("round")
        player.next()
        person = player.player()
        seen = person.play(10, player.step["room"]["seat"])[-1]
        running.process.send_signal(signal.SIGKILL)
        running.process.wait(20)
        running.live.hang_up()
    with study_process(file, tmp_path, port, "--rehearse", "2") as running:  # slower: it goes on while we look
        asking.served = player.served = running  # type: ignore[assignment]
        assert asking.look()["step"]["answers"] == {"age": {"value": 2, "text": ""}}
        assert _visitor(study, "asking", asking.token).kind == "form", "and by the link"
        assert player.look()["step"]["state"] == "playing"
        again = player.player()
        first = again.next_tick(player.step["room"]["seat"])
        assert 2 <= seen - 1 <= first < 120, "the round goes on after the last recorded tick"
        again.play_out(player.step["room"]["seat"])
        player.wait_until(lambda one: one.kind == "questionnaire")
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(30) == 0
    assert [(row["outcome"], row["ticks"]) for row in rows_of(tmp_path, LONG, rounds)] == [("time", 120)]
    (recording,), damaged = list_recordings(tmp_path / "recordings")
    assert damaged == [] and verify(recording.path).identical
    assert len(rows_of(tmp_path, LONG, answers)) == 8


@pytest.mark.slow
def test_what_was_paused_is_paused_after_kill_9_until_the_experimenter_lets_it_go_on(tmp_path: Path) -> None:
    file, port = tmp_path / "study.yaml", free_port()
    file.write_text(LONG, encoding="utf-8")
    with study_process(file, tmp_path, port, "--rehearse", "5") as running:
        study: Any = running
        resting, player = _visitor(study, "resting").go_to("practice"), _visitor(study, "playing").go_to("round")
        player.next()
        seat = player.step["room"]["seat"]
        player.player().play(3, seat)
        (unit,) = {row["unit"] for row in running.state()["participants"] if row["step"] == resting.step["key"]}
        running.ask("pause", unit=unit)
        running.ask("pause")
        token = running.token
        running.process.send_signal(signal.SIGKILL)
        running.process.wait(20)
        running.live.hang_up()
    with study_process(file, tmp_path, port, "--rehearse", "5") as running:
        resting.served = player.served = running  # type: ignore[assignment]
        assert running.state()["paused"]
        assert running.token == token, "the experimenter's page works on"
        assert resting.look()["step"]["kind"] == player.look()["step"]["kind"] == "paused"
        (row,) = [row for row in running.state()["participants"] if row["room"]]
        assert (row["phase"], row["paused"]) == ("paused", True)
        running.ask("resume")
        assert (resting.look()["step"]["kind"], player.look()["step"]["state"]) == ("paused", "playing")
        assert player.player().next_tick(seat) >= 2, "the round goes on where it was"
        running.ask("resume", unit=unit)
        assert resting.look()["step"]["kind"] == "practice"


def _visitor(study: Any, name: str, *known: str) -> Visitor:
    """Somebody who opens the link, in a browser with these tokens."""
    body = {"parameters": {"PROLIFIC_PID": name}, "known": [*known]}
    status, answer = study.live.call("/api/study/arrive", body)
    assert status == 200, answer
    return Visitor(study, answer["token"], answer["view"])


def forget_the_end(study: Served, visitor: Visitor, key: str) -> None:
    """The state after a kill between the last tick and the save of the round."""
    with study.running.databases.store.database.write() as connection:
        connection.execute(update(rounds).values(outcome=None, ended_ms=None, ticks=None, tcr=None))
        connection.execute(update(participants).where(participants.c.pid == visitor.pid).values(step=key))


@pytest.mark.slow
def test_a_round_whose_end_was_not_written_down_is_taken_from_its_recording(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("round")
        key = visitor.step["key"]
        visitor.play()
        (before,) = study.running.databases.store.rows(rounds)
        forget_the_end(study, visitor, key)
    with served(tmp_path) as study:
        assert Visitor(study, visitor.token, {}).look()["step"]["kind"] == "questionnaire"
        (after,) = study.running.databases.store.rows(rounds)
    for name in ("episode", "outcome", "ticks", "tcr", "nfd", "wt_s", "ac", "late_ms"):
        assert (
            after[name] == pytest.approx(before[name], abs=1e-6) if name == "late_ms" else after[name] == before[name]
        )


@pytest.mark.slow
def test_a_round_that_never_had_a_tick_is_played_again(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("round")
        study.running.participants[visitor.pid].device = "gamepad"
        visitor.next()
        room = visitor.step["room"]["id"]
    with served(tmp_path) as study:
        visitor = Visitor(study, visitor.token, visitor.view)
        assert (visitor.look()["step"]["state"], room in study.live.host.registry.rooms) == ("card", False)
        visitor.next()
        assert [row["device"] for row in study.running.databases.store.rows(players)] == ["gamepad", "gamepad"]
        visitor.play()
        assert visitor.kind == "questionnaire"
        assert [(row["attempt"], row["outcome"]) for row in study.running.databases.store.rows(rounds)] == [
            (1, "interrupted"), (2, "time"),
        ]  # fmt: skip


def test_a_server_that_is_stopped_in_a_round_goes_on_with_it(tmp_path: Path) -> None:
    with served(tmp_path, LONG) as study:
        visitor = study.visitor().go_to("round")
        visitor.next()
        visitor.player().play(3, visitor.step["room"]["seat"])
    with served(tmp_path, LONG) as study:
        visitor = Visitor(study, visitor.token, visitor.view)
        assert visitor.look()["step"]["state"] == "playing"
        visitor.player().play_out(visitor.step["room"]["seat"])
        visitor.wait_until(lambda one: one.kind == "questionnaire")
        outcomes = [row["outcome"] for row in study.running.databases.store.rows(rounds)]
    assert outcomes == ["time"]
    assert len(list_recordings(tmp_path / "recordings")[0]) == 1


@pytest.mark.slow
def test_a_round_of_another_study_in_the_folder_waits_until_that_study_is_served_again(tmp_path: Path) -> None:
    other = LONG.replace("id: solo", "id: afternoon")
    with served(tmp_path, LONG) as study:
        visitor = study.visitor().go_to("round")
        visitor.next()
        visitor.player().play(3, visitor.step["room"]["seat"])
    told = "1 round of the study solo was interrupted; it goes on when that study is served again."
    assert told_of_other_studies(tmp_path, "afternoon") == told
    with served(tmp_path, other) as study:
        assert study.live.host.registry.rooms == {}
    assert told_interrupted(tmp_path, "afternoon") == "" != told_interrupted(tmp_path, "solo")
    with served(tmp_path, LONG) as study:
        assert Visitor(study, visitor.token, visitor.view).look()["step"]["state"] == "playing"
        assert [row["outcome"] for row in study.running.databases.store.rows(rounds)] == [None]


@pytest.mark.slow
def test_who_has_a_code_keeps_it(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        done = study.visitor()
        done.agree()
        done.stop(True)
        code = done.step["code"]
    with served(tmp_path) as study:
        assert Visitor(study, done.token, {}).look()["step"]["code"] == code


@pytest.mark.parametrize("left", ["nothing", "an empty file"])
def test_a_study_whose_database_was_lost_is_not_begun_again_with_the_people_who_took_part(
    tmp_path: Path, left: str
) -> None:
    with served(tmp_path) as study:
        study.visitor(PROLIFIC_PID="5f3c").agree()
        database = study.folder.own / "study.sqlite"
    database.unlink()
    if left != "nothing":
        database.touch()
    for _ in range(2):
        with pytest.raises(StudyError, match=r"the identities of participants are there \(1\): it was"):
            StudyDatabases(study.folder, SOLO, Alerts(), simulated=False)


@pytest.mark.slow
@pytest.mark.parametrize("left", ["nothing", "an empty file"])
def test_a_study_whose_identities_were_lost_makes_none_anew_and_says_so(tmp_path: Path, left: str) -> None:
    """Whoever came back was somebody new, and could take part and be paid twice."""
    with served(tmp_path) as study:
        study.visitor(PROLIFIC_PID="5f3c").agree()
        identities = study.folder.own / "identity.sqlite"
    identities.unlink()
    if left != "nothing":
        identities.touch()
    for _ in range(2):
        with pytest.raises(StudyError, match=r"identity.sqlite .* people have taken part \(1\): .* study restore"):
            StudyDatabases(study.folder, SOLO, Alerts(), simulated=False)
    assert not identities.is_file() or identities.stat().st_size == 0


@pytest.mark.slow
def test_a_study_that_nobody_has_come_to_begins_without_identities(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        identities = study.folder.own / "identity.sqlite"
    identities.unlink()
    with served(tmp_path) as study:
        assert study.visitor(PROLIFIC_PID="5f3c").kind == "consent"


@pytest.mark.slow
def test_a_study_goes_on_when_identities_are_deleted_because_they_are_no_longer_needed(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="5f3c")
        visitor.agree()
        study.running.databases.identities.drop([visitor.pid])
    with served(tmp_path) as study:
        assert study.visitor(PROLIFIC_PID="new").kind == "consent"


def test_a_damaged_database_says_what_helps(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        study.visitor(PROLIFIC_PID="5f3c").agree()
        database = study.folder.own / "study.sqlite"
    os.truncate(database, database.stat().st_size // 2)
    with pytest.raises(StoreError, match=r"damaged.* bring back the last backup: movingout study restore"):
        StudyDatabases(study.folder, SOLO, Alerts(), simulated=False)


def test_who_did_not_pass_the_input_check_is_screened_out_also_after_a_restart(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        slow, other = study.visitor().go_to("input-check"), study.visitor().go_to("input-check")
        for _ in range(2):
            assert slow.call("next", {"key": "input-check", "rtt_ms": 400.0, "device": "keyboard"})[0] == 422
        refusals = [row["detail"] for row in study.running.databases.store.rows(audit) if row["action"] == "refused"]
        assert refusals == ['{"why": "slow"}'], "once, however often it is tried"
    with served(tmp_path) as study:
        for one, outcome in ((slow, "screened-out"), (other, "withdrew")):
            again = Visitor(study, one.token, one.view)
            again.stop(True)
            assert again.step["outcome"] == outcome
