"""Who has opened the link and not consented: whatever ends the study for them, nothing about them is kept."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from movingout.study.errors import StoreError
from movingout.study.store.removal import UNDECIDED_S
from movingout.study.store.tables import audit, counts, notes, participants
from tests.server.live import ADMIN
from tests.server.study.support import SOLO, Served, Visitor, served


def ended_by_the_experimenter(study: Served, visitor: Visitor) -> None:
    study.ask("kick", pid=visitor.pid, reason="closed the laptop")


def stopped(study: Served, visitor: Visitor) -> None:
    visitor.stop(True)


def stopped_in_a_pause(study: Served, visitor: Visitor) -> None:
    study.ask("pause")
    shown = visitor.look()
    assert (visitor.kind, shown["can_stop"]) == ("paused", False), "the dialog would promise a code"
    visitor.stop(True)
    study.ask("resume")


@pytest.mark.parametrize("end", [ended_by_the_experimenter, stopped, stopped_in_a_pause])
def test_who_is_ended_at_the_consent_has_declined(tmp_path: Path, end: Callable[[Served, Visitor], None]) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="reads")
        pid = visitor.pid
        end(study, visitor)
        visitor.look()
        assert (visitor.kind, visitor.step["code"], visitor.step["outcome"]) == ("code", None, "declined")
        store = study.running.databases.store
        assert (store.rows(participants), store.rows(counts)) == ([], [{"name": "declined", "number": 1}])
        assert study.running.databases.identities.everybody() == {}
        assert [row for row in store.rows(audit) if row["subject"]] == [], "the audit forgets nothing"
        status, payments = study.live.call("/api/experimenter/payments.csv", token=ADMIN)
        assert (status, pid in str(payments)) == (200, False)
        assert [row["pid"] for row in study.state()["participants"]] == []


def test_who_has_consented_can_stop_in_a_pause(solo: Served) -> None:
    visitor = solo.visitor()
    visitor.agree()
    solo.ask("pause")
    assert (visitor.look()["can_stop"], visitor.kind) == (True, "paused")
    solo.ask("resume")


@pytest.mark.parametrize("leaves", ["declines", "is forgotten"])
def test_what_was_noted_about_who_leaves_without_a_consent_is_nowhere(tmp_path: Path, leaves: str) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor()
        study.ask("note", text="Jane SECRETNAME called.", pid=visitor.pid)
        if leaves == "declines":
            visitor.decline()
        else:
            study.later(UNDECIDED_S + 1)
            study.look()
        store = study.running.databases.store
        assert (store.rows(notes), study.running.notes.to_json()) == ([], [])
        study.running.participants._scrub_at = 0.0
        study.look()
        files = [path for path in study.folder.own.glob("study.sqlite*") if b"SECRETNAME" in path.read_bytes()]
        assert files == [], "it is overwritten"


def test_an_id_that_a_kill_left_of_who_was_arriving_goes_at_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(pid: str, language: str) -> None:
        raise StoreError("killed")

    with served(tmp_path) as study:
        here, code = study.visitor(PROLIFIC_PID="reads").pid, study.ask("open-next")["code"]
        monkeypatch.setattr(study.running.databases.store, "arrive", killed)
        assert study.arrive(PROLIFIC_PID="arriving")[0] == 507
        assert len(study.running.databases.identities.everybody()) == 3
    with served(tmp_path) as study:
        identities = study.running.databases.identities
        assert sorted(identities.everybody().values()) == [("code", code), ("prolific", "reads")]
        assert identities.external(here) == ("prolific", "reads")
        assert identities.database.is_unscrubbed(), "it is overwritten soon"
        assert study.visitor(PROLIFIC_PID="arriving").kind == "consent"


def test_after_a_typo_is_mended_the_study_begins_and_who_had_looked_is_asked_again(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="looks")
    with served(tmp_path, SOLO.replace("Thank you", "Thank you!")) as study:
        assert study.running.databases.identities.everybody() == {}
        assert study.live.call("/api/study/view", token=visitor.token)[0] == 401, "their page arrives again"
        assert study.visitor(PROLIFIC_PID="looks").kind == "consent"


def test_after_a_kill_right_after_the_consent_it_holds_and_the_experimenter_can_end_the_study_for_them(
    tmp_path: Path,
) -> None:
    with served(tmp_path) as study:
        pid = study.visitor(PROLIFIC_PID="agreed").pid
        study.running.databases.store.consent(pid, "1", "en", "We record how you play.", ["adult"])
    with served(tmp_path) as study:
        assert study.row(pid)["step"] != "consent", "they are not asked again"
        study.ask("kick", pid=pid, reason="called and wants to stop")
        assert paid(study, pid)


def test_where_an_error_of_the_database_came_right_after_the_consent_it_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(pid: str, step: str) -> None:
        raise StoreError("the disk is full")

    with served(tmp_path) as study:
        store, visitor = study.running.databases.store, study.visitor(PROLIFIC_PID="agreed")
        pid = visitor.pid
        monkeypatch.setattr(store, "move", failing)
        assert visitor.call("next", {"key": "consent", "boxes": ["adult"]})[0] == 507
        assert store.participant(pid).step == "consent"
        study.later(UNDECIDED_S + 1)
        study.look()
        study.ask("kick", pid=pid, reason="never came back")
        assert paid(study, pid)


def test_a_consent_that_is_written_down_though_its_query_failed_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path) as study:
        store, visitor = study.running.databases.store, study.visitor(PROLIFIC_PID="agreed")
        really = store.consent

        def without_an_answer(*consent: Any) -> None:
            really(*consent)
            raise StoreError("the connection was lost")

        with monkeypatch.context() as patched:
            patched.setattr(store, "consent", without_an_answer)
            assert visitor.call("next", {"key": "consent", "boxes": ["adult"]})[0] == 507
        left = study.visitor(PROLIFIC_PID="left").pid
        study.later(UNDECIDED_S + 1)
        study.look()
        assert [row["pid"] for row in study.state()["participants"]] == [visitor.pid] != [left]
        visitor.look()
        visitor.go_to("code")
        assert study.running.databases.store.participant(visitor.pid).outcome == "done"


def paid(study: Served, pid: str) -> bool:
    """Whether somebody has a code, of who stopped or stayed away, and can be found to be paid."""
    record, identities = study.running.databases.store.participant(pid), study.running.databases.identities
    known = identities.external(pid) == ("prolific", "agreed")
    return known and bool(record.code) and record.outcome in ("withdrew", "dropped-out")
