"""What the audit knows of participants, on SQLite and on PostgreSQL."""

from pathlib import Path

from movingout.study.store.removal import decline, drop_undecided
from movingout.study.store.tables import audit
from tests.study.support import Clock, open_store


def test_of_those_who_leave_without_a_consent_the_audit_knows_nothing(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    before = store.rows(audit)
    for pid in ("P1", "P2", "P3"):
        store.arrive(pid, "en")
    arrived = store.participant("P3").arrived_ms
    decline(store, "P1")
    drop_undecided(store, ["P2"])
    assert store.rows(audit) == before
    clock.ms += 5000
    store.consent("P3", "1", "en", "text", [])
    store.consent("P3", "2", "en", "text", [])
    new = store.rows(audit)[len(before) :]
    assert [row["action"] for row in new] == ["arrive", "consent", "consent"]
    assert new[0]["at_ms"] == arrived and len({row["subject"] for row in new}) == 1


def test_who_arrived_in_an_earlier_version_is_in_the_audit_once(place: Path | str) -> None:
    store = open_store(place)
    before = len(store.rows(audit))
    for pid in ("P1", "P2"):
        store.arrive(pid, "en")
    store.audit("participant", "arrive", "P1")  # as earlier versions did, before the consent
    for pid in ("P1", "P2"):
        store.consent(pid, "1", "en", "text", [])
    assert [row["action"] for row in store.rows(audit)[before:]] == ["arrive", "consent", "arrive", "consent"]
