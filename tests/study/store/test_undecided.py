"""Nothing is kept of who has not consented, on SQLite and on PostgreSQL."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from movingout.study.store import IdentityStore, Store
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.removal import Forget, decline, drop_undecided, no_identities
from movingout.study.store.tables import notes, participants
from tests.study.support import TEXT, agree, open_identities, open_store


def dropped(store: Store, pid: str, forget: Forget = no_identities) -> None:
    drop_undecided(store, [pid], forget)


def changed(store: Store, pid: str, forget: Forget) -> None:
    freeze_study(store, "agent-survey", TEXT + "# a typo\n", {}, {"scripted": ""}, forget=forget)


@pytest.mark.parametrize("leave", [decline, dropped])
def test_notes_about_who_leaves_without_a_consent_go_with_them(
    place: Path | str, leave: Callable[[Store, str], None]
) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    for text in ("P1: wears glasses", "P2: Jane called", "The light went out."):
        store.note(text)
    store.arrive("P2", "en")
    leave(store, "P2")
    assert [row["text"] for row in store.rows(notes)] == ["P1: wears glasses", "The light went out."]
    assert store.database.is_unscrubbed(), "what was noted is overwritten at the next time"


@pytest.mark.parametrize("leave", [decline, dropped, changed])
def test_a_kill_between_the_two_databases_leaves_somebody_who_is_found_again(
    place: Path | str, leave: Callable[[Store, str, Forget], None]
) -> None:
    def killed(pids: Sequence[str]) -> None:
        assert pids == ["P1"]
        raise RuntimeError("after their identities are gone")

    store = open_store(place)
    store.arrive("P1", "en")
    with pytest.raises(RuntimeError, match="identities are gone"):
        leave(store, "P1", killed)
    assert [row["pid"] for row in store.rows(participants)] == ["P1"]


def test_identities_of_who_has_consented_meanwhile_stay(place: Path | str) -> None:
    store, forgotten = open_store(place), list[str]()
    agree(store, ["P1"])
    store.arrive("P2", "en")
    drop_undecided(store, ["P1", "P2"], forgotten.extend)
    assert forgotten == ["P2"]


def test_notes_about_who_has_consented_stay(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    store.note("P1: wears glasses")
    drop_undecided(store, ["P1"])
    assert len(store.rows(notes)) == 1 and not store.database.is_unscrubbed()


def test_only_those_who_are_dropped_are_looked_at_and_a_code_stays_good(
    place: Path | str, monkeypatch: pytest.MonkeyPatch
) -> None:
    identities = open_identities(place)
    gone, here, coded = (identities.pid(source, "5f3c")[0] for source in ("prolific", "mturk", "code"))
    for pid in (gone, here, coded):
        identities.open_session(pid, f"hash of {pid}")
        identities.keep_parameters(pid, {"SESSION_ID": pid})
    monkeypatch.delattr(IdentityStore, "everybody")
    identities.drop_visitors([gone, coded, "unknown"])
    assert [identities.external(pid) for pid in (gone, here, coded)] == [None, ("mturk", "5f3c"), ("code", "5f3c")]
    assert [identities.of_session(f"hash of {pid}") for pid in (here, coded)] == [here, None]
    assert identities.parameters() == {here: {"SESSION_ID": here}, coded: {}}, "nothing is kept of who came with a code"
    assert identities.database.is_unscrubbed()
    for said in ({"SESSION_ID": "of who got no page"}, {}):
        identities.database.scrub()
        identities.keep_parameters(coded, said)
        identities.drop_visitors([coded])
        assert identities.parameters()[coded] == {}
        assert identities.database.is_unscrubbed() == bool(said), "overwritten is what there was"
