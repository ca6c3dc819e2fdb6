"""A whole study served on PostgreSQL, as on SQLite; then what is done with its data."""

import json
import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import psycopg
import pytest

from movingout.server.cli import main
from movingout.server.study.arrivals.arrival_link import ArrivalRefused, read_arrival
from movingout.study.errors import StoreLocked
from movingout.study.store import Store
from movingout.study.store.tables import answers, participants, rounds
from tests.database import PostgresServer
from tests.server.cluster.partition import cable_to
from tests.server.cluster.processes import wait_until
from tests.server.study.support import SOLO, Served, Visitor, served


@pytest.mark.slow
def test_a_study_is_served_from_postgresql_and_exported_and_forgotten(
    tmp_path: Path, postgres: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with served(tmp_path, database=postgres) as study:
        visitor = study.visitor(PROLIFIC_PID="5f3c").go_to("questionnaire")
        visitor.answer("teamwork", 5)
    with served(tmp_path, database=postgres) as study:
        visitor = Visitor(study, visitor.token, visitor.view)
        assert visitor.look()["step"]["answers"] == {"teamwork": {"value": 5, "text": ""}}
        visitor.go_to("code")
        assert visitor.step["outcome"] == "done"
        pid, store = visitor.pid, study.running.databases.store
        assert [len(store.rows(table)) for table in (participants, rounds, answers)] == [1, 2, 7 + 1 + 2 * 10]
    file = tmp_path / "study.yaml"
    file.write_text(SOLO, encoding="utf-8")
    place = [str(file), "--data", str(tmp_path), "--database", postgres]
    assert main(["study", "export", *place, "-o", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"]["rounds"] == 2
    assert main(["study", "forget", *place[:1], pid, *place[1:]]) == 0
    assert not any(pid.encode() in path.read_bytes() for path in (tmp_path / "recordings").iterdir())


@pytest.mark.slow
def test_a_nul_character_from_anybody_is_no_fault_of_the_database(tmp_path: Path, postgres: str) -> None:
    """PostgreSQL refuses it in texts, which told the operator, and `/healthz`, that the database was broken."""
    with served(tmp_path, database=postgres) as study:
        visitor = study.visitor(PROLIFIC_PID="5f3c").go_to("questionnaire")
        assert visitor.answer("comment", text="pasted\0 text") == (200, {"saved": True})
        assert visitor.look()["step"]["answers"]["comment"]["text"] == "pasted text"
        study.ask("note", text="a\0 note")
        assert [note["text"] for note in study.state()["notes"]] == ["a note"]
        assert "database" not in study.alerts()


@pytest.mark.parametrize("link", [{"PROLIFIC_PID": "5f\0"}, {"PROLIFIC_PID": "5f", "STUDY_ID": "\0"}, {"code": "\0"}])
def test_a_link_with_a_nul_character_is_refused_before_it_is_looked_for(link: dict[str, str]) -> None:
    with pytest.raises(ArrivalRefused) as refused:
        read_arrival(link, needs_code=False)
    assert refused.value.code == "link"


# ---- a database that does not answer ------------------------------------------------------------------------------


def refused_within(visitor: Visitor, seconds: float) -> None:
    """Two answers at once are refused, the second as soon as the first, and the server says what does not work."""
    begun = time.monotonic()
    status, answer = visitor.answer("teamwork", 4)
    assert (status, answer["error"]["code"]) == (507, "not_saved")
    assert time.monotonic() - begun < seconds
    status, health = visitor.served.live.call("/healthz")
    assert (status, "the database of the study does not answer" in str(health)) == (503, True)


def works_again(study: Served, visitor: Visitor) -> None:
    wait_until(lambda: visitor.answer("teamwork", 4)[0] == 200, "an answer is saved")
    wait_until(lambda: study.live.call("/healthz")[0] == 200, "the server is healthy")


@pytest.mark.slow
def test_a_database_that_cannot_be_reached_is_given_up_and_found_again(tmp_path: Path, postgres: str) -> None:
    with cable_to(postgres) as (cable, address), served(tmp_path, database=address) as study:
        visitor = study.visitor().go_to("questionnaire")
        cable.cut()
        refused_within(visitor, 16.0)
        cable.mend()
        works_again(study, visitor)


@contextmanager
def stopped(server: PostgresServer) -> Iterator[None]:
    """All processes of the database stand still; their machine goes on to accept connections and data."""
    listed = Path(f"/proc/{server.pid}/task/{server.pid}/children").read_text().split()
    pids = [server.pid, *map(int, listed)]
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGCONT)


@pytest.mark.slow
def test_a_database_that_hangs_is_given_up_and_found_again(
    tmp_path: Path, cluster: PostgresServer, postgres: str
) -> None:
    with served(tmp_path, database=postgres) as study:
        visitor = study.visitor().go_to("questionnaire")
        with stopped(cluster):
            refused_within(visitor, 16.0)
        works_again(study, visitor)


@pytest.mark.slow
def test_a_table_that_another_program_holds_is_waited_for_a_few_seconds(tmp_path: Path, postgres: str) -> None:
    with served(tmp_path, database=postgres) as study:
        visitor = study.visitor().go_to("questionnaire")
        with psycopg.connect(postgres) as holder:
            holder.execute("LOCK TABLE answers IN ACCESS EXCLUSIVE MODE")
            assert visitor.answer("teamwork", 4)[0] == 507
        works_again(study, visitor)


@pytest.mark.slow
def test_deleted_rows_are_overwritten_once_nobody_holds_them(postgres: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Everybody else would wait behind it, as long as a backup reads."""
    monkeypatch.setattr("movingout.study.store.database.ANSWER_S", 1)
    with closing(Store(postgres)) as store:
        store.database.hurry()
        with pytest.raises(StoreLocked, match="statement timeout"), store.database.read() as connection:
            connection.exec_driver_sql("SELECT pg_sleep(1.5)")
        with closing(psycopg.connect(postgres)) as holder:
            holder.execute("LOCK TABLE answers IN ACCESS SHARE MODE")
            with pytest.raises(StoreLocked, match="lock timeout"):
                store.database.scrub()
        store.database.scrub()
        with pytest.raises(StoreLocked), store.database.read() as connection:
            connection.exec_driver_sql("SELECT pg_sleep(1.5)")
