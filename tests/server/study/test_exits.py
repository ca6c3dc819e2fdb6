"""Every way out of a served study: there is one code, and the wish about the data is done."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from movingout.recordings.storage.index import list_recordings
from movingout.study.store.tables import answers, participants, rounds
from tests.server.live import ADMIN
from tests.server.study.support import SOLO, Served, Visitor, served


def screened_out(visitor: Visitor) -> None:
    visitor.go_to("input-check")
    status, answer = visitor.call("next", {"key": "input-check", "rtt_ms": 400.0, "device": "keyboard"})
    assert (status, answer["error"]["code"]) == (422, "slow")
    visitor.stop(True)


EXITS: list[tuple[str, Callable[[Visitor], object]]] = [
    ("done", lambda one: one.go_to("code")),
    ("withdrew", lambda one: one.go_to("form").stop(True)),
    ("withdrew", lambda one: one.go_to("practice").stop(False)),
    ("withdrew", lambda one: one.go_to("questionnaire").stop(True)),
    ("screened-out", screened_out),
]


@pytest.mark.parametrize(("outcome", "leave"), EXITS)
def test_every_exit_gives_exactly_one_code(solo: Served, outcome: str, leave: Callable[[Visitor], object]) -> None:
    visitor = solo.visitor()
    leave(visitor)
    first = visitor.step
    assert (first["outcome"], len(first["code"])) == (outcome, 10)
    for again in ("keep", "delete", "decline", "look"):
        {"decline": visitor.decline, "look": visitor.look}.get(again, partial(visitor.stop, again == "keep"))()
        assert (visitor.step["code"], visitor.step["outcome"]) == (first["code"], outcome)
    codes = [row["code"] for row in solo.running.databases.store.rows(participants) if row["code"]]
    assert len(set(codes)) == len(codes)


@pytest.mark.parametrize(("at", "read"), [("form", False), ("practice", True)])
def test_who_stops_once_the_game_has_begun_reads_the_debriefing_beside_the_code(
    solo: Served, at: str, read: bool
) -> None:
    visitor = solo.visitor().go_to(at)
    visitor.stop(False)
    assert (visitor.step["html"], visitor.step["ask_to_keep"]) == ("<h1>Thank you</h1>\n" if read else None, read)


def test_who_stops_and_lets_the_data_be_kept_has_said_so(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    visitor.stop(True)
    assert visitor.step["kept"] is True


@pytest.mark.slow
def test_who_withdraws_with_the_data_is_paid_and_leaves_nothing_behind(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("questionnaire")
        visitor.answer("teamwork", 5)
        visitor.stop(False)
        assert (visitor.step["kept"], bool(visitor.step["code"])) == (False, True)
        pid, store = visitor.pid, study.running.databases.store
    found, _ = list_recordings(tmp_path / "recordings")
    assert found == []
    with served(tmp_path) as study:
        store = study.running.databases.store
        assert (store.rows(rounds), store.rows(answers)) == ([], [])
        assert [(row["pid"], row["outcome"]) for row in store.rows(participants)] == [(pid, "withdrew")]


def test_data_are_deleted_too_when_somebody_says_so_after_the_debrief(solo: Served) -> None:
    visitor = solo.visitor().go_to("debrief")
    status, answer = visitor.call("next", {"key": "debrief"})
    assert (status, answer["error"]["code"]) == (422, "keep")
    visitor.next(keep=False)
    assert (visitor.step["outcome"], visitor.step["kept"]) == ("done", False)
    store = solo.running.databases.store
    visitor.wait_until(lambda one: not [row for row in store.rows(answers) if row["pid"] == one.pid])


@pytest.mark.slow
def test_who_wants_their_data_deleted_leaves_their_place_to_another(tmp_path: Path) -> None:
    with served(tmp_path, SOLO.replace("participants: 400", "participants: 1")) as study:
        first = study.visitor().go_to("debrief")
        first.next(keep=False)
        assert first.look()["step"]["kind"] == "code"
        assert study.arrive(PROLIFIC_PID="next")[0] == 200
        _, state = study.live.call("/api/experimenter/state", token=ADMIN)
        assert (state["counts"]["finished"], state["counts"]["planned"]) == (0, 1)
