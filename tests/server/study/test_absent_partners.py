"""Partners who do not come back: who stays waits for them for a while, and is free to go then."""

import json
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import update

from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.store.removal import remove_participant
from movingout.study.store.tables import answers, participants, rounds, units
from tests.server.cluster.processes import wait_until
from tests.server.study.support import PAIR, Served, Visitor, served
from tests.server.study.test_pairs import paired, together

pytestmark = pytest.mark.slow


def test_the_partner_of_who_does_not_come_back_is_not_kept_waiting(pair: Served) -> None:
    first, second = paired(pair)
    pair.later(26, staying=second)
    pair.look()
    second.look()
    first.look()
    assert (first.step["outcome"], second.step["outcome"]) == ("dropped-out", "partner-left")
    assert "gone" in pair.alerts()


@pytest.mark.parametrize("own", [{}, {"dropped-out": "AWAY0000"}])
def test_who_does_not_come_back_gets_a_code_of_the_file(own: dict[str, str], tmp_path: Path) -> None:
    codes = {"withdrew": "STOP0000", "partner-left": "LEFT0000", **own}
    with served(tmp_path, f"{PAIR}codes: {json.dumps(codes)}\n") as study:
        first, second = paired(study)
        study.later(26, staying=second)
        study.look()
        first.look()
        assert first.step["code"] == own.get("dropped-out", "STOP0000"), "files of before have no code for it"
        assert first.step["shared_code"], "it finds nobody"


def test_when_both_are_away_nobody_is_sent_away(pair: Served) -> None:
    first, second = paired(pair)
    pair.later(600)
    pair.look()
    assert (first.look()["step"]["kind"], second.look()["step"]["kind"]) == ("practice", "practice")


def test_who_comes_back_first_waits_for_the_other(tmp_path: Path) -> None:
    with served(tmp_path, PAIR.replace("return_s: 5}", "return_s: 60}")) as study:
        first, second = paired(study)
        study.later(100)
        first.look()
        study.look()
        study.later(20, staying=first)
        study.look()
        assert (first.look()["step"]["kind"], second.look()["step"]["kind"]) == ("practice", "practice")
        study.later(100)
        first.look()
        study.later(61, staying=first)
        study.look()
        assert (first.look()["step"]["outcome"], second.look()["step"]["outcome"]) == ("partner-left", "dropped-out")


@pytest.mark.parametrize(("looked_at_s", "silent_s"), [(0, 61), (30, 90)], ids=["a hidden tab", "a phone"])
def test_a_page_that_is_heard_now_and_then_waits_on_in_between(
    looked_at_s: float, silent_s: float, tmp_path: Path
) -> None:
    with served(tmp_path, PAIR.replace("return_s: 5}", "return_s: 60}")) as study:
        first, second = paired(study)
        for kind in ("practice", "code"):  # it waits since it was heard without the other
            study.later(looked_at_s, staying=first)
            study.later(silent_s)
            first.look()
            study.look()
            assert first.look()["step"]["kind"] == kind
        assert (first.look()["step"]["outcome"], second.look()["step"]["outcome"]) == ("partner-left", "dropped-out")


def test_who_comes_back_first_after_a_stop_of_the_server_waits_for_the_other(tmp_path: Path) -> None:
    text = PAIR.replace("return_s: 5}", "return_s: 60}")
    with served(tmp_path, text) as study:
        first, second = paired(study)
    with closing(StudyFolder(parse_study(text), tmp_path).open()) as store, store.database.write() as connection:
        connection.execute(update(participants).values(last_seen_ms=participants.c.last_seen_ms - 600_000))
    with served(tmp_path, text) as study:
        first, second = (Visitor(study, one.token, one.view) for one in (first, second))
        first.look()
        study.later(40, staying=first)
        study.look()
        assert first.look()["step"]["kind"] == "practice", "the other one may be on the way"
        study.later(30, staying=first)
        study.look()
        assert (first.look()["step"]["outcome"], second.look()["step"]["outcome"]) == ("partner-left", "dropped-out")


def test_nobody_is_sent_away_in_a_pause_and_the_wait_begins_anew_after_it(pair: Served) -> None:
    first, second = paired(pair)
    pair.ask("pause", pid=first.pid)
    pair.later(600)
    second.look()
    pair.look()
    pair.ask("resume", pid=first.pid)
    second.look()
    pair.look()
    assert (first.look()["step"]["kind"], second.look()["step"]["kind"]) == ("practice", "practice")


@pytest.mark.parametrize("away", [False, True])
def test_rounds_that_a_time_limit_skips_are_not_to_come(away: bool, tmp_path: Path) -> None:
    text = PAIR.replace("rounds: 2", "rounds: 2, limit_minutes: 1, after_round: [nasa-tlx]")
    with served(tmp_path, text + "at_end: [nasa-tlx]\n") as study:
        first, second = paired(study)
        for _ in range(2):
            together(first, second)
        assert first.kind == second.kind == "questionnaire"
        with study.running.databases.store.database.write() as connection:
            connection.execute(update(rounds).values(started_ms=rounds.c.started_ms - 60_000))  # a long round
        if away:
            study.later(26, staying=second)
        else:
            first.stop(True)
        study.look()
        second.look()
        assert second.kind == "questionnaire", "the second round is skipped: nobody is needed for it"
        second.go_to("code")
        assert second.step["outcome"] == "done"


LIMITED = PAIR.replace("rounds: 2", "rounds: 2, limit_minutes: 1, after_round: [nasa-tlx], after_partner: [nasa-tlx]")
LIMITED += "at_end: [nasa-tlx]\ndebrief: {text: Thank you}\n"


def after_a_long_round(study: Served) -> tuple[Visitor, Visitor]:
    """A pair at the questions about the first round, which took all the time of the block."""
    first, second = paired(study)
    for _ in range(2):
        together(first, second)
    with study.running.databases.store.database.write() as connection:
        connection.execute(update(rounds).values(started_ms=rounds.c.started_ms - 60_000))
    return first, second


def wants_the_deletion(study: Served, visitor: Visitor, at: str) -> None:
    visitor.look()
    if at == "stop":
        visitor.stop(False)
    else:
        visitor.go_to("debrief").next(keep=False)
    wait_until(lambda: not study.running.databases.store.rows(rounds), "the deletion of the rounds")


@pytest.mark.parametrize("at", ["stop", "debrief"])
def test_the_time_of_a_block_stays_over_when_the_partner_has_the_rounds_deleted(tmp_path: Path, at: str) -> None:
    with served(tmp_path, LIMITED) as study:
        first, second = after_a_long_round(study)
        wants_the_deletion(study, first, at)
        study.look()
        second.look()
        asked = []
        while second.kind != "code":
            asked.append(second.step["key"].rpartition("/")[0])
            second.do()
        assert (second.step["outcome"], asked) == ("done", ["play/1/HandOff-1", "play/1", "end", ""])


def test_nobody_waits_at_a_round_for_a_partner_who_is_done(tmp_path: Path) -> None:
    with served(tmp_path, LIMITED) as study:
        first, second = after_a_long_round(study)
        wants_the_deletion(study, first, "debrief")
    with served(tmp_path, LIMITED) as study:  # nothing tells any more that the time was up
        second = Visitor(study, second.token, second.view)
        second.look()
        second.go_to("round").next()
        study.look()
        assert second.look()["step"]["outcome"] == "partner-left"


def removed(study: Served, pid: str) -> None:
    """`study forget`, once the server has ended."""
    store = study.folder.open()
    try:
        remove_participant(store, pid, 0)
    finally:
        store.close()


def test_the_partner_of_who_is_removed_from_the_data_plays_with_no_agent_instead(tmp_path: Path) -> None:
    with served(tmp_path, PAIR) as study:
        first, second = paired(study)
        gone = first.pid
    removed(study, gone)
    with served(tmp_path, PAIR) as study:
        second = Visitor(study, second.token, second.view)
        assert second.look()["step"]["outcome"] == "partner-left"
        assert [row["state"] for row in study.running.databases.store.rows(units)] == ["dropped"]


def test_who_has_only_questions_left_answers_them_about_the_partner_who_was_removed(tmp_path: Path) -> None:
    text = PAIR.replace("rounds: 2", "rounds: 1, after_partner: [nasa-tlx]")
    with served(tmp_path, text) as study:
        first, second = paired(study)
        for _ in range(2):
            together(first, second)
        gone = first.pid
    removed(study, gone)
    with served(tmp_path, text) as study:
        second = Visitor(study, second.token, second.view)
        assert second.look()["step"]["kind"] == "questionnaire"
        second.go_to("code")
        assert second.step["outcome"] == "done"
        assert {row["partner"] for row in study.running.databases.store.rows(answers)} == {""}
