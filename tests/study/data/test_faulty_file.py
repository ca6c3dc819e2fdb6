"""A study that has begun, whose file has got faults since: what the database keeps of it counts, deletion goes on."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from tests.study.filled import fill, template
from tests.study.support import agree, open_identities, open_store

FAULTY = "id: {id}\ntitle: 'Ada's'\n"


def run(data: Path, *arguments: str) -> int:
    return main(["study", arguments[0], str(data / "study.yaml"), *arguments[1:], "--data", str(data)])


def begin(data: Path, text: str, more: str = "") -> StudyFolder:
    """P1, of the platform's id 5f3c, and P2 have consented, and both have the code STOP1."""
    folder = StudyFolder(parse_study(text), data)
    store, identities = open_store(folder.own, text=text + more), open_identities(folder.own)
    pid, _ = identities.pid("prolific", "5f3c")
    agree(store, [pid, "P2"], boxes=[])  # by the clock of tests, in September 2026
    for one in (pid, "P2"):
        store.finish(one, "withdrew", "STOP1", 0.0)
    return folder


@pytest.mark.parametrize("more", ["", "maps_of_an_earlier_version: 1\n"])  # with which it cannot be read as it began
def test_a_participant_is_forgotten_and_a_fixed_code_names_nobody(
    more: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = template("agent_survey", **{"codes: unique": "codes: {withdrew: STOP1}"})[1]
    folder = begin(tmp_path, text, more)
    (tmp_path / "study.yaml").write_text(FAULTY.format(id=folder.study.id), encoding="utf-8")
    assert run(tmp_path, "forget", "STOP1") == 2
    assert "'STOP1' is the code of all who end alike" in capsys.readouterr().err
    assert run(tmp_path, "forget", "5f3c") == 0
    told = capsys.readouterr()
    assert "identity: removed" in told.out and "warning: study.yaml has 1 fault" in told.err


@pytest.mark.parametrize("command", [["export", "--no-training", "-o"], ["report", "-o"], ["purge", "--apply"]])
def test_tables_and_retention_go_by_the_study_as_it_began(
    command: Sequence[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, text = template("human_study")
    fill(tmp_path, study, text, 2)
    (tmp_path / "study.yaml").write_text(FAULTY.format(id=study.id), encoding="utf-8")
    out = [str(tmp_path / "out")] if "-o" in command else []
    assert run(tmp_path, *command, *out) == 0
    assert "is not used, but the study as it began" in capsys.readouterr().err


@pytest.mark.parametrize("more", ["", "maps_of_an_earlier_version: 1\n"])
def test_what_a_warning_quotes_of_the_file_does_not_command_the_terminal(
    more: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = begin(tmp_path, template("agent_survey")[1], more)
    (tmp_path / "study.yaml").write_text(f'id: {folder.study.id}\n"\\e[31mred": 1\n', encoding="utf-8")
    assert run(tmp_path, "forget", "P2") == 0
    told = capsys.readouterr().err
    assert "warning: " in told and "[31mred: there is no such field" in told and "\x1b" not in told


@pytest.mark.parametrize("command", [["forget", "P2"], ["purge"], ["purge", "--apply"]])
def test_what_deletes_takes_no_study_for_a_file_that_says_no_id(
    command: Sequence[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The only study of the folder was taken, which may be another one than the file's."""
    folder = begin(tmp_path, template("agent_survey")[1])
    (tmp_path / "study.yaml").write_text("title: 'Ada's'\n", encoding="utf-8")
    assert run(tmp_path, *command) == 2
    told = capsys.readouterr().err
    assert "study.yaml has 1 fault" in told
    assert f"has data of {folder.study.id}; say which in a line of the file, id: NAME" in told
    (tmp_path / "study.yaml").write_text(FAULTY.format(id=folder.study.id), encoding="utf-8")
    assert run(tmp_path, *command) == 0


def test_where_nothing_was_recorded_the_faults_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "study.yaml").write_text(FAULTY.format(id="mine"), encoding="utf-8")
    assert run(tmp_path, "export") == 2
    assert "this is not YAML" in capsys.readouterr().err


def test_where_the_file_has_gone_the_command_that_writes_it_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = begin(tmp_path, template("agent_survey")[1])
    assert run(tmp_path, "forget", "P2") == 2
    assert "`movingout study backup` writes it" in capsys.readouterr().err
    shutil.rmtree(folder.own)
    assert run(tmp_path, "forget", "P2") == 2
    assert "backup" not in capsys.readouterr().err
