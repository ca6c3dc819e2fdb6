"""A whole study served on PostgreSQL, as on SQLite; then what is done with its data."""

import json
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.store.tables import answers, participants, rounds
from tests.server.study.support import SOLO, Visitor, served


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
