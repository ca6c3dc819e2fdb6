"""The store: what is written stays, what may not happen does not, on SQLite and on PostgreSQL."""

import stat
import threading
from contextlib import closing
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import create_engine

from movingout.study.errors import StoreError, StudyError
from movingout.study.store import Store, Unit, database
from movingout.study.store.database import Database, alembic_config
from movingout.study.store.frozen_study import frozen_study
from movingout.study.store.removal import decline, rounds_by_participant, with_data, withdraw_data
from movingout.study.store.rounds import PlayerOutcome, Rounds
from movingout.study.store.tables import (
    answers,
    audit,
    consents,
    counts,
    identity_metadata,
    metadata,
    participants,
    rounds,
    units,
)
from tests.study.support import PLAYED, Clock, agree, open_identities, open_store, rounds_of


def test_the_migrations_make_exactly_the_tables(place: Path | str) -> None:
    store = open_store(place)
    with store.database.read() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []


def test_the_identities_have_their_own_file_that_nobody_else_reads(tmp_path: Path) -> None:
    open_identities(tmp_path)
    with closing(Database(tmp_path / "identity.sqlite", "identity")) as database, database.read() as connection:
        assert compare_metadata(MigrationContext.configure(connection), identity_metadata) == []
    assert stat.S_IMODE((tmp_path / "identity.sqlite").stat().st_mode) == 0o600


def test_a_database_of_an_older_version_is_brought_forward_with_its_rows(tmp_path: Path) -> None:
    path = tmp_path / "study.sqlite"
    engine = create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        command.upgrade(alembic_config("main", connection), "0002")
        for statement in (
            "INSERT INTO study VALUES ('pilot', 1, '', '', '{}', '{}', 'salt', 0)",
            "INSERT INTO units VALUES (1, 0, 'active', 1)",
            "INSERT INTO participants (pid, unit, member, language, step, arrived_ms, paid_ms)"
            " VALUES ('P1', 1, 0, 'en', 'form', 7, 9)",
        ):
            connection.exec_driver_sql(statement)
    engine.dispose()
    with closing(Store(path)) as store:
        assert frozen_study(store).id == "pilot" and not store.paused()
        assert [(one.pid, one.step, one.arrived_ms) for one in store.everybody()] == [("P1", "form", 7)]
        assert (store.participant("P1").away_ms, store.participant("P1").last_seen_ms) == (0, None)
        assert store.units_on_their_way() == (Unit(1, 0, ("P1",), paused=False),)


def test_a_store_that_is_opened_again_holds_everything(place: Path | str) -> None:
    clock = Clock()
    store = open_store(place, clock)
    agree(store, ["P1"])
    store.move("P1", "practice")
    before = {name: store.rows(table) for name, table in store.tables().items()}
    store.close()
    again = open_store(place, clock)
    assert again.arrive("P1", "de").step == "practice"
    assert {name: again.rows(table) for name, table in again.tables().items()} == before


def test_a_consent_is_kept_with_the_hash_of_the_shown_text(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    (row,) = store.rows(consents)
    assert (row["pid"], row["version"], row["boxes"]) == ("P1", "1", '["release"]')
    assert row["sha256"] == sha256(b"We record how you play.").hexdigest()
    assert store.has_consented("P1", "1") and not store.has_consented("P1", "2")


def test_who_declines_is_a_number_and_nothing_else(place: Path | str) -> None:
    store = open_store(place)
    for pid in ("P1", "P2"):
        store.arrive(pid, "en")
        decline(store, pid)
    assert store.rows(participants) == []
    assert store.rows(counts) == [{"name": "declined", "number": 2}]


def test_no_round_begins_and_no_answer_is_kept_before_everybody_has_consented(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    store.arrive("P2", "en")
    unit = store.form_unit(["P1", "P2"])
    seated = [PlayerOutcome("P1", 0, "keyboard"), PlayerOutcome("P2", 1, "gamepad")]
    with pytest.raises(StudyError, match="no tick is played before everybody has consented"):
        Rounds(store).begin(unit, rounds_of(0)[0], "episode-1", seated)
    with pytest.raises(StudyError, match="nothing is kept before the consent"):
        store.answer("P2", "form", "demographics", "", "age", 1, "", 10.0)
    assert store.rows(rounds) == [] and store.rows(answers) == []


def test_a_round_is_one_row_per_attempt_and_only_finished_valid_ones_count(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    unit, play, (first, second, *_) = store.form_unit(["P1"]), Rounds(store), rounds_of(0)
    seated = [PlayerOutcome("P1", 0, "keyboard")]
    assert play.begin(unit, first, "a", seated) == 1
    play.end("a", PLAYED, [PlayerOutcome("P1", 0, "keyboard", rtt_ms=12.0, idle_share=0.25)])
    play.mark("a", valid=False)
    assert play.begin(unit, first, "b", seated) == 2
    play.end("b", PLAYED)
    play.begin(unit, second, "c", seated)
    assert play.finished_steps(unit.id) == {first.key}
    assert play.open_episodes() == {"c": unit.id}
    assert [(row["episode"], row["attempt"], row["position"], row["valid"]) for row in store.rows(rounds)] == [
        ("a", 1, 1, False),
        ("b", 2, 2, True),
        ("c", 1, 3, True),
    ]


def test_the_newest_click_counts_and_every_click_is_kept(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    for value in (3, 6):
        store.answer("P1", "play/1/nine", "nine", "scripted", "teamwork", value, "", 100.0)
    assert {item: one[:2] for item, one in store.answers("P1", "play/1/nine").items()} == {"teamwork": (6, "")}
    assert [row["value"] for row in store.rows(answers)] == [3, 6]


def test_every_exit_gives_exactly_one_code(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1"])
    assert store.finish("P1", "withdrew", "CODE-1") == "CODE-1"
    assert store.finish("P1", "done", "CODE-2") == "CODE-1"
    assert (store.participant("P1").outcome, store.participant("P1").step) == ("withdrew", "code")


def test_the_slot_of_who_withdraws_is_given_to_the_next_and_the_row_stays(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2", "P3", "P4"])
    assert [store.form_unit([pid]).slot for pid in ("P1", "P2", "P3")] == [0, 1, 2]
    store.finish("P2", "withdrew", "CODE-2")
    store.finish("P1", "done", "CODE-1")
    assert store.form_unit(["P4"]).slot == 1
    assert [row["state"] for row in store.rows(units)] == ["done", "dropped", "active", "active"]


def test_a_unit_is_formed_once_however_often_it_is_asked_for(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2", "P3"])
    assert store.form_unit(["P1", "P2"]) == store.form_unit(["P1", "P2"])
    with pytest.raises(StudyError, match="P2 plays in another pair already"):
        store.form_unit(["P3", "P2"])


def test_many_who_come_at_once_get_a_slot_each(place: Path | str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database, "BUSY_S", 60.0)  # eight wait here for each other, where a server has one thread
    store = open_store(place)
    pids = [f"P{number}" for number in range(8)]
    agree(store, pids)
    slots: list[int] = []
    threads = [threading.Thread(target=lambda pid=pid: slots.append(store.form_unit([pid]).slot)) for pid in pids]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(slots) == list(range(8))


@pytest.mark.parametrize("statement", ["DELETE FROM audit", "UPDATE audit SET actor = 'nobody'"])
def test_the_database_itself_refuses_to_change_the_audit(place: Path | str, statement: str) -> None:
    store = open_store(place)
    before = store.rows(audit)
    with pytest.raises(StoreError, match="the audit only grows"), store.database.write() as connection:
        connection.exec_driver_sql(statement)
    assert store.rows(audit) == before != []


def test_the_audit_names_nobody(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["PQRSTUV"])
    store.finish("PQRSTUV", "done", "CODE")
    assert "PQRSTUV" not in str(store.rows(audit))
    assert len({row["subject"] for row in store.rows(audit)} - {""}) == 1


def test_who_comes_again_is_the_same_participant(tmp_path: Path) -> None:
    identities = open_identities(tmp_path)
    pid, new = identities.pid("prolific", "5f3c", {"session": "s1"})
    assert new and identities.pid("prolific", "5f3c") == (pid, False)
    assert identities.pid("mturk", "5f3c")[0] != pid
    assert identities.external(pid) == ("prolific", "5f3c")
    assert identities.forget(pid) == 1 and identities.external(pid) is None


def test_the_browser_that_was_opened_last_speaks_for_the_participant(tmp_path: Path) -> None:
    identities = open_identities(tmp_path)
    pid, _ = identities.pid("code", "K7QX")
    assert (identities.known("code", "K7QX"), identities.known("code", "K7Q")) == (pid, None)
    identities.open_session(pid, "hash of the first")
    identities.open_session(pid, "hash of the second")
    assert identities.of_session("hash of the first") is None
    assert identities.of_session("hash of the second") == pid
    assert identities.everybody() == {pid: ("code", "K7QX")}


def test_after_a_restart_it_is_known_who_is_on_their_way(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2", "P3", "P4"])
    pair, other = store.form_unit(["P1", "P2"]), store.form_unit(["P3", "P4"])
    store.finish("P3", "withdrew", "CODE-3")
    left = replace(other, dropped=True)
    assert store.units_on_their_way() == (pair, left), "P4 is, though the partner has left"
    store.finish("P4", "partner-left", "CODE-4")
    assert store.units_on_their_way() == (pair,)


def test_what_is_paused_stays_so_until_it_is_let_go_on(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2"])
    first, second = (store.form_unit([pid]) for pid in ("P1", "P2"))
    assert (store.paused(), first.paused, second.paused) == (False, False, False)
    store.pause(True)
    store.pause(True, second.id)
    store.close()
    store = open_store(place)
    assert (store.paused(), [unit.paused for unit in store.units_on_their_way()]) == (True, [False, True])
    store.pause(False)
    store.pause(False, second.id)
    assert (store.paused(), [unit.paused for unit in store.units_on_their_way()]) == (False, [False, False])


def test_two_at_one_screen_read_on_in_their_language(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2"])
    store.set_shared_screen(["P1", "P2"], "a1b2")
    store.set_language("P2", "de")
    assert [(one.screen, one.language) for one in store.everybody()] == [("a1b2", "en"), ("a1b2", "de")]


def test_what_a_participant_did_goes_at_their_wish_and_the_code_stays(place: Path | str) -> None:
    store = open_store(place)
    agree(store, ["P1", "P2"])
    unit = store.form_unit(["P1"])
    step = rounds_of(unit.slot)[0]
    Rounds(store).begin(unit, step, "e1", [PlayerOutcome("P1", 0, "keyboard")])
    for pid in ("P1", "P2"):
        store.answer(pid, "form", "demographics", "", "age", 2, "", 900.0, 100.0)
    store.finish("P1", "withdrew", "CODE-1")
    ((pid, played),) = rounds_by_participant(store, ["P1", "P2"]).items()
    assert with_data(store, ["P1", "PN"]) == {"P1"} == {pid} and [row["episode"] for row in played] == ["e1"]
    assert withdraw_data(store, {"P1": 1, "PN": 0}) == 3 and with_data(store, ["P1"]) == set()
    assert (store.rows(rounds), [row["pid"] for row in store.rows(answers)]) == ([], ["P2"])
    assert store.participant("P1").code == "CODE-1" and len(store.rows(consents)) == 2
    assert withdraw_data(store, {"P1": 0}) == 0, "asking again changes nothing"
    store.note("Came back for her umbrella.", unit.id)
    assert with_data(store, ["P1"]) == {"P1"}, "a note of later is about them"
    assert [row["action"] for row in store.rows(audit)].count("withdraw") == 1
