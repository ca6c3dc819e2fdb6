"""The nightly test of a backup: it says whether the backup is good, and leaves nothing behind."""

import hashlib
import json
import shutil
import tempfile
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.data.backup import back_up
from tests.server.study.support import served


@pytest.fixture(scope="module")
def backup(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("backup")
    with served(place / "data") as study:
        study.visitor(PROLIFIC_PID="5f3c").go_to("questionnaire")
    back_up(study.folder, place / "first", 1_800_000_000.0)
    return place / "first"


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where temporary folders are made."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.chdir(tmp_path)
    return folder


def check(backup: Path, *more: str) -> int:
    return main(["study", "restore", str(backup), "--check", *more])


def test_a_good_backup_is_read_whole_and_nothing_is_left(
    backup: Path, temporary: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert check(backup) == 0
    assert "of solo is good: restored and read, 1 recordings" in capsys.readouterr().out
    assert (list(temporary.iterdir()), list(tmp_path.iterdir())) == ([], [temporary])
    assert check(backup, "--json") == 0
    assert json.loads(capsys.readouterr().out)["good"] is True


def rewritten(backup: Path, copy: Path, name: str, content: bytes) -> Path:
    """A backup with another file in it, of which the manifest has the right checksum."""
    shutil.copytree(backup, copy)
    (copy / name).write_bytes(content)
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest["files"][name] = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    return copy


def test_what_was_spoiled_before_it_was_saved_is_found_too(
    backup: Path, temporary: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = next(str(path.relative_to(backup)) for path in backup.rglob("*.mcap"))
    for number, (name, said) in enumerate(
        {
            recording: "has recordings that cannot be read",
            "study.sqlite": "not a database",
            "identity.sqlite": "not a database",
        }.items()
    ):
        assert check(rewritten(backup, tmp_path / str(number), name, b"nonsense " * 1000)) == 2
        assert said in capsys.readouterr().err
    assert list(temporary.iterdir()) == []


def test_it_writes_into_no_database(backup: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert check(backup, "--database", "postgresql://somebody@nowhere/x") == 2
    assert "leave --database, --identities and --cluster out" in capsys.readouterr().err
