"""Pauses, and the absences around them, which are not paid where they are long."""

import pytest
from sqlalchemy import update

from movingout.study.store.tables import participants
from tests.server.study.support import Served, Visitor


def away(study: Served, visitor: Visitor, seconds: float) -> None:
    """As if so much time had passed without the visitor, on every clock."""
    session = study.running.participants[visitor.pid]
    for clock in ("last_seen_at", "resumed_at", "unpaid_until"):
        setattr(session, clock, getattr(session, clock) - seconds)
    earlier = participants.c.arrived_ms - round(1e3 * seconds)
    with study.running.databases.store.database.write() as connection:
        connection.execute(update(participants).where(participants.c.pid == visitor.pid).values(arrived_ms=earlier))


def test_who_was_away_for_long_and_came_back_is_not_paid_for_it(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    session = solo.running.participants[visitor.pid]
    away(solo, visitor, 50_000)
    visitor.look()
    solo.look()
    assert session.record.away_ms >= 50_000_000, "kept at the next look, also over a restart"
    away(solo, visitor, 200)
    visitor.look()
    solo.ask("pause")
    away(solo, visitor, 6_000)
    visitor.look()
    solo.ask("resume")
    away(solo, visitor, 40_000)
    visitor.look()
    visitor.stop(True)
    assert (200 + 6_000) / 60 <= solo.row(visitor.pid)["minutes"] < (200 + 6_000) / 60 + 5, "pauses are paid"


@pytest.mark.parametrize("returns", ["in the pause", "after it", "after another one", "never"])
def test_a_long_absence_before_a_pause_is_not_paid_and_counts_once(solo: Served, returns: str) -> None:
    visitor = solo.visitor().go_to("round")
    away(solo, visitor, 50_000)
    solo.ask("pause", pid=visitor.pid)
    solo.ask("pause")
    away(solo, visitor, 6_000)
    if returns == "in the pause":
        visitor.look()
    solo.ask("resume")
    solo.ask("resume", pid=visitor.pid)
    if returns == "after another one":
        away(solo, visitor, 60)
        solo.ask("pause")
        solo.ask("resume")
    if returns != "never":
        visitor.look()
    solo.ask("kick", pid=visitor.pid)
    paid_s = 6_000 + (60 if returns == "after another one" else 0)
    assert paid_s / 60 <= solo.row(visitor.pid)["minutes"] < paid_s / 60 + 5


def test_who_is_ended_in_a_pause_that_began_in_their_absence_is_not_paid_for_it_and_did_not_come_back(
    solo: Served,
) -> None:
    visitor = solo.visitor().go_to("form")
    solo.ask("pause")
    away(solo, visitor, 60_000)
    visitor.look()
    solo.ask("resume")
    away(solo, visitor, 50_000)
    solo.ask("pause")
    solo.look()
    solo.ask("kick", pid=visitor.pid)
    solo.ask("resume")
    row = solo.row(visitor.pid)
    assert row["outcome"] == "dropped-out" and 60_000 / 60 <= row["minutes"] < 60_000 / 60 + 5, "counted once"
