"""Addresses of databases that are not the study's: what only looks makes nothing there, what deletes is refused."""

from pathlib import Path

import psycopg
import pytest

from movingout.server.cli import main
from movingout.study.design import partner_speed
from movingout.study.store.tables import participants
from tests.study.filled import template
from tests.study.support import TEXT, agree, open_identities, open_store


def tables_of(address: str) -> list[str]:
    with psycopg.connect(address) as connection:
        found = connection.execute("SELECT tablename FROM pg_tables WHERE schemaname = 'public'")
        return [str(name) for (name,) in found.fetchall()]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def run(file: Path, command: str, *arguments: str) -> int:
    return main(["study", command, str(file), "--data", str(file.parent / "data"), *arguments])


def test_check_makes_no_tables_in_an_empty_database_and_says_what_it_says_without(
    file: Path, postgres: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where a study cannot begin as it is, the check looks whether it has begun."""
    monkeypatch.setattr(partner_speed, "decision_ms", lambda agent_id, the_map: 500.0)
    assert run(file, "check", "--json") == 1
    without = capsys.readouterr()
    assert run(file, "check", "--json", "--database", postgres) == 1
    assert capsys.readouterr() == without
    assert tables_of(postgres) == []


@pytest.mark.parametrize("command", [["forget", "P1"], ["purge", "--apply"], ["export", "--no-training"], ["backup"]])
def test_an_empty_database_is_refused_and_stays_empty(
    command: list[str], file: Path, postgres: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *arguments = command
    assert run(file, name, *arguments, "--database", postgres) == 2
    assert f"study agent-survey has no data in {postgres}, which no study was served from" in capsys.readouterr().err
    assert tables_of(postgres) == []


def test_an_empty_database_of_identities_is_refused_before_a_participant_is_half_forgotten(
    file: Path, postgres: str, capsys: pytest.CaptureFixture[str]
) -> None:
    store = open_store(file.parent / "data" / "studies" / "agent-survey")
    agree(store, ["P1"])
    assert run(file, "forget", "P1", "--identities", postgres) == 2
    assert f"study agent-survey has no identities in {postgres}" in capsys.readouterr().err
    assert tables_of(postgres) == [] and len(store.rows(participants)) == 1


@pytest.mark.parametrize("command", [["forget", "P1"], ["purge", "--apply"]])
def test_nobody_is_deleted_from_the_database_of_another_study(
    command: list[str], file: Path, postgres: str, capsys: pytest.CaptureFixture[str]
) -> None:
    other, text = template("human_study")
    store = open_store(postgres)
    agree(store, ["P1"])
    open_identities(file.parent / "data" / "studies" / other.id)
    file.write_text(text, encoding="utf-8")
    name, *arguments = command
    assert run(file, name, *arguments, "--database", postgres) == 2
    said = f"has the data of the study agent-survey, not of {other.id}; give the address of the database of {other.id}"
    assert said in capsys.readouterr().err
    assert len(store.rows(participants)) == 1
