"""A database of a study that is older than that of its identities: nobody is removed whom it merely does not know."""

import shutil
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.commands.data import older_database_told
from movingout.study.data import backup
from movingout.study.data.backup import back_up
from movingout.study.data.erasure import due_now, purge, unknown_to
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StudyError
from movingout.study.store import IdentityStore, Store
from movingout.study.store.database import Kind
from movingout.study.store.removal import UNDECIDED_S, decline
from movingout.study.store.store import Participant
from tests.server.persistence.test_room_snapshot import free_port
from tests.server.study.study_process import study_process
from tests.server.study.support import SOLO, served
from tests.study.support import Clock, agree, open_identities, open_store, study


def come(store: Store, identities: IdentityStore, external_id: str) -> str:
    """Somebody arrives, gets a page and consents; returns the pseudonym."""
    pid, _ = identities.pid("prolific", external_id)
    agree(store, [pid])
    identities.open_session(pid, f"hash of {external_id}")
    return pid


def test_beside_an_older_database_a_start_removes_nobody_and_purge_asks_for_an_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, data, before = tmp_path / "study.yaml", tmp_path / "data", tmp_path / "before.sqlite"
    file.write_text(SOLO, encoding="utf-8")
    with served(data) as running:
        running.visitor(PROLIFIC_PID="early").agree()
        own = running.folder.own
        assert older_database_told(running.folder) == []
    shutil.copy2(own / "study.sqlite", before)
    with served(data) as running:
        late = running.visitor(PROLIFIC_PID="late")
        late.agree()
        pid = late.pid
    shutil.copy2(before, own / "study.sqlite")
    with served(data) as running:
        (told,) = older_database_told(running.folder)
        assert told.startswith("1 of the identities are of people who opened the study") and "study restore" in told
    for option in ([], ["--apply"]):
        assert main(["study", "purge", str(file), "--data", str(data), *option]) == 2
        told = capsys.readouterr().err
        assert "1 of the identities are of people who opened the study" in told and "--unknown" in told
    with closing(IdentityStore(own / "identity.sqlite")) as identities:
        assert identities.external(pid) == ("prolific", "late")
    assert main(["study", "purge", str(file), "--data", str(data), "--unknown", "--apply"]) == 0


@pytest.mark.slow
def test_a_server_beside_an_older_database_says_so_at_the_start(tmp_path: Path) -> None:
    file, data = tmp_path / "study.yaml", tmp_path / "data"
    file.write_text(SOLO, encoding="utf-8")
    with served(data) as before:
        before.visitor(PROLIFIC_PID="early").agree()
        own = before.folder.own
    with closing(IdentityStore(own / "identity.sqlite")) as identities:
        identities.open_session(identities.pid("prolific", "late")[0], "hash of a browser")
    with study_process(file, data, free_port()) as running:
        assert running.process.stdout is not None
        printed = "".join(running.process.stdout.readline() for _ in range(3))
    assert "warning: 1 of the identities are of people who opened the study" in printed


def test_with_the_option_who_is_unknown_goes_after_half_an_hour_and_nobody_else(tmp_path: Path) -> None:
    folder, clock = StudyFolder(study(), tmp_path), Clock()
    store, identities = open_store(folder.own, clock), open_identities(folder.own)
    known, unknown = come(store, identities, "5f3a"), identities.pid("prolific", "5f3b")[0]
    assert due_now(folder, store).undecided == (), "who is just arriving is no sign of an older database"
    identities.open_session(unknown, "hash of their browser")
    for look in (due_now, purge):
        with pytest.raises(StudyError, match="it is older than the identities"):
            look(folder, store)
    clock.ms += round(1e3 * UNDECIDED_S)
    assert purge(folder, store, unknown_too=True).undecided == (unknown,)
    assert [*identities.everybody()] == [known]


def test_who_declines_while_it_is_looked_is_no_sign_of_an_older_database(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = StudyFolder(study(), tmp_path)
    store, identities = open_store(folder.own), open_identities(folder.own)
    pid, _ = identities.pid("prolific", "5f3a")
    store.arrive(pid, "en")
    identities.open_session(pid, "hash of their browser")
    really = store.everybody

    def everybody() -> Sequence[Participant]:
        if identities.external(pid):
            decline(store, pid, identities.drop)
        return really()

    monkeypatch.setattr(store, "everybody", everybody)
    assert unknown_to(store, identities) == [] and identities.external(pid) is None


def test_a_backup_holds_identities_as_of_the_moment_of_its_database(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, really = StudyFolder(study(), tmp_path), backup._save
    store, identities = open_store(folder.own), open_identities(folder.own)
    known = come(store, identities, "5f3a")
    unknown, coded = identities.pid("prolific", "5f3b")[0], identities.pid("code", "ABCD")[0]
    identities.open_session(unknown, "hash of somebody of a newer database")

    def save(address: str | None, file: Path, kind: Kind, target: Path) -> None:
        really(address, file, kind, target)
        if kind == "main":
            come(store, identities, "5f3c")
            agree(store, [coded])
            identities.open_session(coded, "hash of who came with the code")

    monkeypatch.setattr(backup, "_save", save)
    back_up(folder, tmp_path / "made", 1_800_000_000.0)
    assert b"5f3c" not in (tmp_path / "made" / "identity.sqlite").read_bytes()
    assert [path.name for path in (tmp_path / "made").glob("identity*")] == ["identity.sqlite"]
    with closing(IdentityStore(tmp_path / "made" / "identity.sqlite")) as kept:
        assert {*kept.everybody()} == {known, unknown, coded}
        assert kept.of_session("hash of who came with the code") is None, "the code is good, nobody has come with it"
