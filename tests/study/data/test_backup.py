"""A backup that was made while people play is restored, and they go on from where they were."""

import json
import shutil
from pathlib import Path

import pytest

from movingout.recordings import verify
from movingout.recordings.annotation.verdicts import add_verdict, new_line, verdicts_of
from movingout.recordings.storage.listing import recording_paths
from movingout.recordings.storage.s3_bucket import DELETED, note_uploads, uploads_of
from movingout.server.cli import main
from movingout.study.data import backup
from movingout.study.data.backup import back_up, restore
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StudyError
from movingout.study.store.tables import answers, rounds
from tests.recordings.full_disk import limited
from tests.server.study.support import SOLO, served
from tests.study.support import open_identities, open_store, study


@pytest.fixture(scope="module")
def backed_up(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, str]:
    """A backup of a study with one round played and one participant in the middle; a second one linked to it."""
    place = tmp_path_factory.mktemp("backup")
    with served(place / "data") as study:
        visitor = study.visitor(PROLIFIC_PID="stays").go_to("questionnaire")
        visitor.answer("teamwork", 6)
        study.live.run(lambda: None)
        (episode,) = (str(row["episode"]) for row in study.running.databases.store.rows(rounds))
        for recording in (episode, "another"):
            add_verdict(study.folder.recordings, new_line(f"{recording}:keeps:0:10", "confirmed", "Ada"))
        back_up(study.folder, place / "first", 1_800_000_000.0)
        visitor.answer("humanlike", 2)  # after the backup
        back_up(study.folder, place / "second", 1_800_000_100.0, previous=place / "first")
        token = visitor.token
    return place / "first", place / "second", token


def test_a_restored_study_goes_on_where_the_backup_was_made(backed_up: tuple[Path, Path, str], tmp_path: Path) -> None:
    first, _, token = backed_up
    done = restore(first, tmp_path)
    assert (done.study, done.recordings, done.identities) == ("solo", 1, True)
    found = recording_paths(tmp_path / "recordings")
    [said] = verdicts_of(tmp_path / "recordings")
    assert said.recording == found[0].name.partition(".")[0] and said.annotator == "Ada", "of this study alone"
    with served(tmp_path) as study:
        given = {
            row["item"]
            for row in study.running.databases.store.rows(answers)
            if row["item"] in ("teamwork", "humanlike")
        }
        assert given == {"teamwork"}, "as it was at the backup"
        returned = study.visitor(PROLIFIC_PID="stays", known=[token])
        assert returned.kind == "questionnaire" and returned.step["answers"]["teamwork"]["value"] == 6
        assert returned.go_to("code").step["outcome"] == "done"
        assert all(row["ticks"] for row in study.running.databases.store.rows(rounds))
    # The server has ended, so no journal becomes a recording meanwhile.
    found = recording_paths(tmp_path / "recordings")
    assert len(found) >= 2 and all(verify(path).identical for path in found)


def test_what_has_not_changed_takes_no_room_twice(backed_up: tuple[Path, Path, str]) -> None:
    first, second, _ = backed_up
    [name] = [path.name for path in (first / "recordings").glob("*.mcap")] or [""]
    if name:
        assert (second / "recordings" / name).samefile(first / "recordings" / name)
    assert (second / "manifest.json").read_text() != (first / "manifest.json").read_text()
    assert not [path for path in second.rglob("*-wal")]


def test_a_damaged_backup_is_not_restored(backed_up: tuple[Path, Path, str], tmp_path: Path) -> None:
    first, _, _ = backed_up
    spoiled = {
        "study.sqlite": b"nonsense",
        "identity.sqlite": b"",
        "manifest.json": b"[" * 100_000,
        "./manifest.json": b'{"format": 1, "study": "solo", "identities": false, "files": {"../x": {}}}',
        "././manifest.json": b'{"format": 1, "study": "solo", "files": {}}',
    }
    for number, (name, content) in enumerate(spoiled.items()):
        copy = tmp_path / f"copy{number}"
        shutil.copytree(first, copy)
        (copy / name).write_bytes(content)
        with pytest.raises(StudyError, match=r"damaged|no backup"):
            restore(copy, tmp_path / "data")
        assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("study", ["x/../../y", "..", "/tmp/y", "", 1])
def test_a_backup_of_a_study_that_no_study_file_can_have_is_not_restored(tmp_path: Path, study: object) -> None:
    """The folder is named by it."""
    about = {"format": 1, "study": study, "identities": False, "files": {}}
    (tmp_path / "manifest.json").write_text(json.dumps(about))
    with pytest.raises(StudyError, match="is no backup of a study"):
        restore(tmp_path, tmp_path / "data")
    assert [path.name for path in tmp_path.iterdir()] == ["manifest.json"]


def test_nothing_is_overwritten(backed_up: tuple[Path, Path, str], tmp_path: Path) -> None:
    first, _, _ = backed_up
    restore(first, tmp_path)
    with pytest.raises(StudyError, match="has data of the study solo already"):
        restore(first, tmp_path)


def test_a_restored_study_knows_where_copies_of_its_recordings_are(tmp_path: Path) -> None:
    """Else `forget` would leave them there."""
    for name, address, episode in (("data", "s3://one/a", "gone"), ("other", "s3://two/b", "left")):
        data = tmp_path / name
        data.mkdir()
        (data / DELETED).write_text(f"{episode}.mcap\n")
        note_uploads(data, address)
    folder = StudyFolder(study(), tmp_path / "data")
    open_store(folder.own).close()
    back_up(folder, tmp_path / "backup", 1_800_000_000.0, identities=False)
    restore(tmp_path / "backup", tmp_path / "other")
    assert uploads_of(tmp_path / "other") == ["s3://two/b", "s3://one/a"]
    assert (tmp_path / "other" / DELETED).read_text() == "left.mcap\ngone.mcap\n"


def test_a_restoration_that_is_broken_off_leaves_nothing_and_works_again(
    backed_up: tuple[Path, Path, str], tmp_path: Path
) -> None:
    first, _, _ = backed_up
    (recording,) = (first / "recordings").iterdir()
    with limited(recording.stat().st_size // 2), pytest.raises(StudyError, match="cannot restore into"):
        restore(first, tmp_path)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == []
    restore(first, tmp_path)


def test_a_recording_that_was_there_stays_when_a_restoration_is_interrupted(
    backed_up: tuple[Path, Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, _, _ = backed_up
    (recording,) = (first / "recordings").iterdir()
    kept = tmp_path / "data" / "recordings" / recording.name
    kept.parent.mkdir(parents=True)
    shutil.copy2(recording, kept)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(backup, "_fill", interrupted)
    for data, left in (("data", [recording.name]), ("empty", [])):
        with pytest.raises(KeyboardInterrupt):
            restore(first, tmp_path / data)
        assert [path.name for path in (tmp_path / data).rglob("*.mcap*")] == left
        assert not list((tmp_path / data / "studies").iterdir())


def test_a_backup_that_is_stopped_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    folder = StudyFolder(study(), tmp_path / "data")
    open_store(folder.own)
    monkeypatch.setattr(backup, "_copy_recordings", stopped)
    with pytest.raises(KeyboardInterrupt):
        back_up(folder, tmp_path / "kept", 1_800_000_000.0, identities=False)
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_the_commands_say_what_they_did(
    backed_up: tuple[Path, Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, _, _ = backed_up
    file, data = tmp_path / "study.yaml", str(tmp_path / "data")
    file.write_text(SOLO)
    assert main(["study", "restore", str(first), "--data", data]) == 0
    assert "every checksum right" in capsys.readouterr().out
    out = ["-o", str(tmp_path / "again")]
    assert main(["study", "backup", str(file), "--data", data, "--no-identities", "--json", *out]) == 0
    assert json.loads(capsys.readouterr().out)["missing"] == []
    assert not (tmp_path / "again" / "identity.sqlite").exists()
    assert main(["study", "backup", str(file), "--data", data, *out]) == 2
    assert main(["study", "backup", str(file), "--data", str(tmp_path / "none")]) == 2
    assert main(["study", "restore", str(tmp_path), "--data", data]) == 2
    assert main(["study", "backup", str(file), "--data", data, "--database", "postgresql://x/y"]) == 2
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("movingout: ")]
    assert len(said) == 4, "a sentence each, among what the server beside says"


def test_a_backup_is_made_where_the_study_file_has_faults(
    backed_up: tuple[Path, Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A copy of it in another folder, say, beside which the maps are missing."""
    first, _, _ = backed_up
    file, data = tmp_path / "study.yaml", str(tmp_path / "data")
    restore(first, tmp_path / "data")
    file.write_text(SOLO.replace("maps: [", "maps: [maps/gone.json, ", 1))
    assert "gone" in file.read_text()
    command = ["study", "backup", str(file), "--data", data, "-o", str(tmp_path / "again")]
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "wrote" in told and "warning: the study file cannot be read: study.yaml has 1 fault" in told
    assert (tmp_path / "again" / "study.yaml").read_text() == (first / "study.yaml").read_text(), "as it began"
    assert restore(tmp_path / "again", tmp_path / "other").recordings == 1
    broken = f"title: 'Ada's'\n  - id: other\n{SOLO}"
    for number, content in enumerate((broken.encode(), broken.encode("utf-16"), b"id: [1]\nblocks: 3", b"\0", None)):
        file.unlink() if content is None else file.write_bytes(content)
        assert main([*command[:-1], str(tmp_path / f"broken-{number}")]) == 0, content
        assert "the data of the study solo were copied" in capsys.readouterr().out


def test_a_backup_says_where_nothing_tells_which_study_of_several_is_meant(
    backed_up: tuple[Path, Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, data = tmp_path / "study.yaml", tmp_path / "data"
    restore(backed_up[0], data)
    (data / "studies" / "another").mkdir()
    file.write_text("id: [1]\nblocks: 3")
    command = ["study", "backup", str(file), "--data", str(data), "-o", str(tmp_path / "again")]
    assert main(command) == 2, "whose data would that be?"
    assert "has data of another, solo; say which in a line of the file, id: NAME" in capsys.readouterr().err
    file.write_text("title: 'Ada's'\nid: solo  # ours\n")
    assert main(command) == 0


@pytest.mark.parametrize("name", ["Pilot #2", "100%25", "sure?"])
def test_a_folder_may_have_a_name_that_addresses_would_read_otherwise(tmp_path: Path, name: str) -> None:
    folder = StudyFolder(study(), tmp_path / name)
    open_store(folder.own).arrive("P1", "en")
    open_identities(folder.own).pid("prolific", "5f3c")
    back_up(folder, tmp_path / "backup", 1_800_000_000.0)
    restore(tmp_path / "backup", tmp_path / f"{name} again")
    assert open_store(tmp_path / f"{name} again" / "studies" / folder.study.id).participant("P1").language == "en"
    assert {path.name for path in tmp_path.iterdir()} == {name, "backup", f"{name} again"}


def test_a_backup_without_the_file_of_identities_names_it_and_the_option(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path / "data")
    open_store(folder.own)
    with pytest.raises(StudyError, match=r"identity.sqlite, which .* is not there; --no-identities"):
        back_up(folder, tmp_path / "backup", 1_800_000_000.0)
    assert not folder.has_identities
    back_up(folder, tmp_path / "backup", 1_800_000_000.0, identities=False)


@pytest.mark.parametrize("check", [[], ["--check"]])
def test_a_mistyped_path_is_no_damaged_backup(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], check: list[str]
) -> None:
    assert main(["study", "restore", str(tmp_path / "bk"), "--data", str(tmp_path / "data"), *check]) == 2
    assert f"cannot read {tmp_path / 'bk'}: there is no such file or folder; check the name" in capsys.readouterr().err
