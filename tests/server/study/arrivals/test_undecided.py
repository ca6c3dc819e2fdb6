"""Who has opened the link and not consented: whatever ends the study for them, nothing about them is kept."""

from collections.abc import Callable
from pathlib import Path

import pytest

from movingout.study.store.tables import audit, counts, participants
from tests.server.live import ADMIN
from tests.server.study.support import Served, Visitor, served


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
