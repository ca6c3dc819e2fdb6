"""Pairs: a waiting room that never hangs, two at one screen, and partners who are left behind."""

import threading
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qsl

import pytest

from movingout.recordings.storage.index import list_recordings
from movingout.server import messages as m
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.study.design.definition import SUBSTITUTE
from movingout.study.design.step_order import WAITING
from movingout.study.store.removal import UNDECIDED_S
from movingout.study.store.tables import answers, rounds
from tests.server.cluster.processes import wait_until
from tests.server.live import Person
from tests.server.study.support import PAIR, Served, Visitor, served

pytestmark = pytest.mark.slow


def waiting(study: Served, count: int = 1) -> list[Visitor]:
    return [study.visitor().go_to("waiting") for _ in range(count)]


def paired(study: Served) -> tuple[Visitor, Visitor]:
    """A pair at the start of the practice."""
    (first,) = waiting(study)
    second = study.visitor().go_to("input-check")
    second.do()
    first.look()
    assert (first.kind, second.kind) == ("practice", "practice")
    return first, second


def together(*visitors: Visitor) -> None:
    """Both do the same at the same time."""
    threads = [threading.Thread(target=visitor.do) for visitor in visitors]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
        assert not thread.is_alive()


def test_the_experimenter_sees_who_lost_the_connection_at_once(pair: Served) -> None:
    both = first, second = paired(pair)
    for visitor in both:
        visitor.next()
    first.look()
    players = [visitor.player() for visitor in both]
    players[0].next_tick(first.step["room"]["seat"])
    players[1].connection.close()
    wait_until(lambda: pair.row(first.pid)["phase"] == "paused", "the round waits")
    rows = [pair.row(visitor.pid) for visitor in both]
    assert [(row["present"], row["waits_for"]) for row in rows] == [(True, [second.pid]), (False, [second.pid])]
    players[0].connection.close()


def test_two_browsers_find_each_other_and_play_to_the_end(pair: Served) -> None:
    (first,) = waiting(pair)
    assert (first.step["people"], first.step["wait_s"], first.step["otherwise"]) == (1, 30, "code")
    second = pair.visitor().go_to("input-check")
    second.do()
    first.look()
    assert {first.step["seat"], second.step["seat"]} == {0, 1}
    assert (first.step["partner_letter"], first.step["state"]) == (None, "card")
    first.next()
    assert first.step["state"] == "waiting", "the round waits for both"
    for _ in range(3):
        together(first, second)
    assert (first.step["outcome"], second.step["outcome"]) == ("done", "done")
    assert first.step["code"] != second.step["code"]
    unit = pair.running.participants[first.pid].record.unit
    store = pair.running.databases.store
    assert [row["outcome"] for row in store.rows(rounds) if row["unit"] == unit] == ["time", "time"]


def test_practice_waits_for_a_partner_whose_move_was_cut_off(pair: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kill or a database error came between the moves of the pair; the next check completes them."""

    async def nobody_looks(tx: Transaction, unit: StudyUnit) -> None:
        pass

    first, second = paired(pair)
    late = pair.running.participants[second.pid]
    with monkeypatch.context() as patch:
        patch.setattr(pair.running.units, "move_to_first_step", nobody_looks)
        pair.live.run(lambda: setattr(late, "record", replace(late.record, step=WAITING)))
        assert first.next()["step"]["state"] == "waiting"
        assert second.look()["step"]["kind"] == "waiting"
    second.wait_until(lambda one: one.kind == "practice")
    assert second.next()["step"]["state"] == "playing"
    assert first.look()["step"]["state"] == "playing"


def test_two_at_one_screen_are_a_pair_whoever_else_waits(pair: Served) -> None:
    (stranger,) = waiting(pair)
    first = pair.visitor().go_to("input-check")
    second = pair.visitor(beside=first.token).go_to("input-check")
    first.do()
    assert first.kind == "waiting", "not with the stranger"
    second.do()
    first.look()
    assert (first.kind, second.kind, stranger.look()["step"]["kind"]) == ("practice", "practice", "waiting")
    assert pair.row(first.pid)["partner_pid"] == second.pid
    stranger.stop(True)


def test_nobody_is_added_beside_somebody_whose_partner_has_come(pair: Served) -> None:
    (first,) = waiting(pair)
    beside = first.token
    other = pair.visitor().go_to("practice")
    came = len(list(pair.running.participants))
    status, answer = pair.arrive(beside=beside)
    assert (status, answer["error"]["code"]) == (403, "partner_came")
    assert len(list(pair.running.participants)) == came, "nothing is kept of them"
    assert pair.row(first.pid)["partner_pid"] == other.pid


def test_where_the_file_says_so_nobody_is_added_at_a_screen(tmp_path: Path) -> None:
    with served(tmp_path, PAIR.replace("return_s: 5}", "return_s: 5, one_screen: off}")) as study:
        assert not study.live.call("/api/study")[1]["one_screen"]
        first = study.visitor()
        alone = study.visitor(beside=first.token)
        screens = [study.running.participants[one.pid].record.screen for one in (first, alone)]
    assert screens == ["", ""], "who comes all the same came by themselves"


def test_who_was_invited_brings_one_person_who_needs_no_link(tmp_path: Path) -> None:
    with served(tmp_path, PAIR, signed=True) as study:
        first = study.visitor(**dict(parse_qsl(study.running.signer.query("P01", 4_000_000_000))))
        study.visitor(beside=first.token).decline()
        lost = study.visitor(beside=first.token).pid
        second = study.visitor(beside=first.token)
        assert second.pid == lost, "the answer was lost, and the page asked again"
        assert [study.arrive(beside=token)[0] for token in (second.token, "wrong", "")] == [403] * 3
        first.go_to("waiting")
        second.go_to("practice")
        assert study.row(first.pid)["partner_pid"] == second.pid
        status, answer = study.arrive(beside=first.token)
        assert (status, answer["error"]["code"]) == (403, "partner_came"), "they have begun"


@pytest.mark.parametrize("leaves", ["declines", "stops", "goes away"])
def test_who_is_left_alone_at_a_screen_may_play_with_anybody(pair: Served, leaves: str) -> None:
    first = pair.visitor()
    second = pair.visitor(beside=first.token)
    first.go_to("waiting")
    if leaves == "declines":
        second.decline()
    elif leaves == "stops":
        second.go_to("input-check").stop(True)
    else:
        pair.running.participants[second.pid].last_seen_at -= UNDECIDED_S + 1
    pair.look()
    stranger = pair.visitor().go_to("practice")
    assert first.look()["step"]["kind"] == "practice"
    assert pair.row(first.pid)["partner_pid"] == stranger.pid


@pytest.mark.parametrize("stays", [True, False])
def test_who_waits_for_the_other_one_at_their_screen_waits_until_they_come(pair: Served, stays: bool) -> None:
    (first,) = waiting(pair)
    pair.running.participants[first.pid].step_since -= 100
    second = pair.visitor(beside=first.token)
    pair.look()
    if not stays:
        pair.running.participants[second.pid].last_seen_at -= 100
        pair.later(31, staying=first)
    pair.look()
    if stays:
        assert first.look()["step"]["kind"] == "waiting", "the other one still reads the consent"
        second.go_to("practice")
        assert first.look()["step"]["kind"] == "practice"
    else:
        assert first.look()["step"]["outcome"] == "no-partner", "they closed the page"


def test_two_at_one_screen_are_a_pair_after_a_restart_too(tmp_path: Path) -> None:
    with served(tmp_path, PAIR) as study:
        first = study.visitor().go_to("input-check")
        second = study.visitor(beside=first.token).go_to("input-check")
    with served(tmp_path, PAIR) as study:
        (stranger,) = waiting(study)
        first, second = Visitor(study, first.token, first.view), Visitor(study, second.token, second.view)
        first.do()
        second.do()
        assert (first.look()["step"]["kind"], stranger.look()["step"]["kind"]) == ("practice", "waiting")


def test_who_waits_too_long_gets_a_code(pair: Served) -> None:
    (alone,) = waiting(pair)
    pair.later(31, staying=alone)
    pair.look()
    alone.look()
    assert (alone.step["outcome"], bool(alone.step["code"])) == ("no-partner", True)


@pytest.mark.parametrize("otherwise", ["code", "agent"])
def test_who_has_left_the_waiting_room_when_the_wait_is_over_did_not_come_back(tmp_path: Path, otherwise: str) -> None:
    """No partner is missing where nobody waits for one."""
    with served(tmp_path, PAIR.replace("return_s: 5}", f"return_s: 5, otherwise: {otherwise}, agent: idle}}")) as study:
        (gone,) = waiting(study)
        study.later(31)
        study.look()
        gone.look()
        assert (gone.step["outcome"], bool(gone.step["code"])) == ("dropped-out", True)


@pytest.mark.parametrize(("own", "code"), [("", "NONE0000"), (", withdrew: STOP0000", "STOP0000")])
def test_who_has_left_the_waiting_room_gets_a_code_of_the_file(tmp_path: Path, own: str, code: str) -> None:
    with served(tmp_path, f"{PAIR}codes: {{done: DONE0000, no-partner: NONE0000{own}}}\n") as study:
        (gone,) = waiting(study)
        study.later(31)
        study.look()
        gone.look()
        assert (gone.step["outcome"], gone.step["code"]) == ("dropped-out", code)


def test_who_waits_too_long_may_play_with_an_agent_instead(tmp_path: Path) -> None:
    text = PAIR.replace("return_s: 5}", "return_s: 5, otherwise: agent, agent: idle}")
    text = text.replace("limit_ticks: 20", "limit_ticks: 20, after_partner: [movingout-paper-nine]")
    assert "after_partner" in text
    with served(tmp_path, text) as study:
        (alone,) = waiting(study)
        study.later(31)
        alone.look()
        study.look()
        alone.look()
        assert (alone.kind, alone.step["partner_letter"]) == ("practice", None)
        alone.go_to("round")
        assert alone.step["partner_letter"] == "A", "nobody is told that it is a person"
        alone.go_to("code")
        assert alone.step["outcome"] == "done"
        store = study.running.databases.store
        assert {row["partner"] for row in store.rows(rounds)} == {SUBSTITUTE}, "not taken for a round of two people"
        about = {row["partner"] for row in store.rows(answers) if row["step"].partition("/")[0] != "end"}
        assert about == {SUBSTITUTE}
    found, _ = list_recordings(tmp_path / "recordings")
    assert all("idle" in (one.blue + one.red) for one in found) and len(found) == 2


def test_a_closed_page_is_not_paired(pair: Served) -> None:
    (ghost,) = waiting(pair)
    pair.later(25)
    (second,) = waiting(pair)
    assert second.kind == "waiting"
    ghost.stop(True)
    second.stop(True)


def test_the_partner_of_who_leaves_is_free_to_go_and_paid(pair: Served) -> None:
    first, second = paired(pair)
    first.next()
    second.next()
    person = second.player()
    first.stop(True)
    second.look()
    assert (first.step["outcome"], second.step["outcome"]) == ("withdrew", "partner-left")
    assert first.step["code"] != second.step["code"]
    code, _ = person.end()
    assert code == m.CLOSE_ROOM_OVER


@pytest.mark.parametrize("keep", [False, True])
def test_who_stops_at_the_same_time_as_the_partner_says_what_becomes_of_their_data_too(
    pair: Served, keep: bool
) -> None:
    first, second = paired(pair)
    first.stop(False)
    second.stop(keep)
    assert (second.step["outcome"], second.step["kept"]) == ("partner-left", keep)
    code = second.step["code"]
    second.stop(not keep)
    assert (second.step["code"], second.step["kept"]) == (code, keep), "the first answer counts"


def test_the_answers_of_both_who_stop_at_the_same_time_are_deleted(tmp_path: Path) -> None:
    with served(tmp_path, PAIR.replace('demographics: ""', "demographics: demographics")) as study:
        first, second = paired(study)
        store = study.running.databases.store
        assert {row["pid"] for row in store.rows(answers)} == {first.pid, second.pid}
        first.stop(False)
        second.stop(False)
        wait_until(lambda: not store.rows(answers), "the deletion of both")


def test_the_end_of_a_units_pause_lets_nobody_in_the_waiting_room_wait_longer(pair: Served) -> None:
    first, _ = paired(pair)
    (alone,) = waiting(pair)
    pair.later(20)
    pair.ask("pause", pid=first.pid)
    pair.ask("resume", pid=first.pid)
    assert alone.look()["step"]["since_s"] >= 20
    pair.ask("pause")
    pair.ask("resume")
    assert alone.look()["step"]["since_s"] < 20, "a pause of everybody is no wait"
    alone.stop(True)


def test_who_has_only_questions_left_can_finish_without_the_partner(tmp_path: Path) -> None:
    with served(tmp_path, PAIR + "at_end: [nasa-tlx]\n") as study:
        first, second = paired(study)
        for _ in range(3):
            together(first, second)
        assert first.kind == second.kind == "questionnaire"
        first.stop(True)
        second.go_to("code")
        assert second.step["outcome"] == "done"


def test_practice_ends_when_both_have_had_enough_and_a_round_can_be_begun_again(tmp_path: Path) -> None:
    text = PAIR.replace("limit_ticks: 30", "limit_ticks: 3000").replace("limit_ticks: 20", "limit_ticks: 150")
    with served(tmp_path, text) as study:
        first, second = paired(study)
        enough(first, second)
        assert (second.kind, first.look()["step"]["kind"]) == ("round", "round")
        begun_again(study, first, second)


def enough(first: Visitor, second: Visitor) -> None:
    """The first of two has practised enough, and then the second."""
    players = both_play(first, second)
    first.next(done=True)
    players[0].connection.close()
    assert (first.kind, first.step["state"]) == ("round", "card"), "a reload or a restart changes nothing about that"
    first.next()
    assert first.step["state"] == "waiting"
    seat = second.step["room"]["seat"]
    tick = players[1].next_tick(seat)
    assert players[1].next_tick(seat) > tick, "the other practises on"
    second.look()
    assert second.step["state"] == "playing"
    second.next(done=True)


def begun_again(study: Served, first: Visitor, second: Visitor) -> None:
    """The experimenter restarts a round."""
    key = first.step["key"]
    both_play(second, first)
    study.ask("restart-round", pid=first.pid, reason="the fire alarm")
    for visitor in (first, second):
        visitor.wait_until(lambda one: one.step["state"] == "card")
    together(first, second)
    mine = [row for row in study.running.databases.store.rows(rounds) if row["step"] == key]
    assert [(row["attempt"], row["outcome"]) for row in mine] == [(1, "stopped"), (2, "time")]
    assert any("the fire alarm" in note["text"] for note in study.state()["notes"])


def both_play(first: Visitor, second: Visitor) -> tuple[Person, Person]:
    first.next()
    second.next()
    first.look()
    players = first.player(), second.player()
    players[0].wait_for("room", phase="playing")
    return players
