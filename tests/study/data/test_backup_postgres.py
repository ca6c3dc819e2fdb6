"""Backups of studies whose databases are in PostgreSQL, restored there and as files."""

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.data.backup import MAIN, back_up, restore
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError
from movingout.study.store.identity import identities_in
from movingout.study.store.store import Store
from movingout.study.store.tables import answers, rounds
from tests.database import PostgresServer
from tests.server.study.support import SOLO, served


@pytest.fixture(scope="module")
def backed_up(tmp_path_factory: pytest.TempPathFactory, cluster: PostgresServer) -> tuple[Path, str, str]:
    """A backup made by the command while a participant is at a questionnaire; the address; the participant's token."""
    place, address = tmp_path_factory.mktemp("backup"), cluster.new_database()
    file = place / "study.yaml"
    file.write_text(SOLO, encoding="utf-8")
    with served(place / "data", database=address) as study:
        visitor = study.visitor(PROLIFIC_PID="stays").go_to("questionnaire")
        visitor.answer("teamwork", 6)
        study.live.run(lambda: None)
        arguments = [str(file), "--data", str(place / "data"), "--database", address, "-o", str(place / "backup")]
        assert main(["study", "backup", *arguments]) == 0
        visitor.answer("humanlike", 2)  # after the backup
        token = visitor.token
    return place / "backup", address, token


def all_rows(address: Path | str) -> dict[str, list[dict[str, object]]]:
    with closing(Store(address)) as store:
        return {name: store.rows(table) for name, table in store.tables().items()}


@pytest.mark.slow
def test_a_study_restored_into_postgresql_goes_on(
    backed_up: tuple[Path, str, str], postgres: str, tmp_path: Path
) -> None:
    backup, _, token = backed_up
    done = restore(backup, tmp_path, postgres)
    assert (done.study, done.recordings, done.identities) == ("solo", 1, True)
    assert sorted(path.name for path in (tmp_path / "studies" / "solo").iterdir()) == ["identity.sqlite", "link-key"]
    copied = tmp_path / "copy.sqlite"
    shutil.copy2(backup / MAIN, copied)
    assert all_rows(postgres) == all_rows(copied)
    with served(tmp_path, database=postgres) as study:
        store = study.running.databases.store
        assert {row["item"] for row in store.rows(answers)} >= {"teamwork"}
        assert "humanlike" not in {row["item"] for row in store.rows(answers)}
        returned = study.visitor(PROLIFIC_PID="stays", known=[token])
        assert returned.go_to("code").step["outcome"] == "done"  # rows are numbered on from the highest
        assert study.visitor(PROLIFIC_PID="new").go_to("code").step["outcome"] == "done"
        assert len(store.rows(rounds)) == 4


@pytest.mark.slow
def test_both_databases_of_a_cluster_go_into_a_new_one_and_into_files(
    backed_up: tuple[Path, str, str], postgres: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    backup, _, _ = backed_up
    assert main(["study", "restore", str(backup), "--data", str(tmp_path / "nodes"), "--cluster", postgres]) == 0
    folder = StudyFolder(parse_study(SOLO), tmp_path / "nodes", postgres, identities_in(postgres))
    with closing(folder.open_identities()) as identities:
        assert [external for _, external in identities.everybody().values()] == ["stays"]
    again = back_up(folder, tmp_path / "again", 1_800_000_000.0)
    assert restore(again.folder, tmp_path / "files").study == "solo"
    assert all_rows(tmp_path / "files" / "studies" / "solo" / MAIN) == all_rows(postgres)


def test_a_used_database_and_another_study_are_refused_before_anything_is_written(
    backed_up: tuple[Path, str, str], postgres: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    backup, used, _ = backed_up
    with pytest.raises(StudyError, match=r"has data of a study already; give the address of an empty database"):
        restore(backup, tmp_path / "data", used)
    assert not (tmp_path / "data").exists()
    other = parse_study(SOLO.replace("id: solo", "id: other"))
    with pytest.raises(StudyError, match=r"the database holds the study solo, not other"):
        back_up(StudyFolder(other, tmp_path, used), tmp_path / "backup", 0.0, identities=False)
    with pytest.raises(StudyError, match=r"which no study was served from"):
        back_up(StudyFolder(other, tmp_path, postgres), tmp_path / "backup", 0.0, identities=False)
    assert list(tmp_path.iterdir()) == []
    file = tmp_path / "study.yaml"
    file.write_text(SOLO, encoding="utf-8")
    assert main(["study", "backup", str(file), "--cluster", "sqlite:///x"]) == 2
    assert "is no address of PostgreSQL" in capsys.readouterr().err
