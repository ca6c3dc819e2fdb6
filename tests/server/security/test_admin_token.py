"""The admin token of a data folder: the same at every start, and read by nobody but its owner."""

import os
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from movingout.server.commands.play import with_kept_token
from movingout.server.persistence.data_folder import BadDataFolder
from movingout.server.security.admin_token import NAME, kept_token
from movingout.server.security.kept_secret import kept_secret
from movingout.server.settings import Settings


def test_the_token_is_the_same_at_every_start_and_readable_by_its_owner_alone(tmp_path: Path) -> None:
    token = kept_token(tmp_path)
    assert len(token) >= 20 and kept_token(tmp_path) == token
    assert [path.name for path in tmp_path.iterdir()] == [NAME]
    assert stat.S_IMODE((tmp_path / NAME).stat().st_mode) == 0o600


def test_another_data_folder_has_another_token(tmp_path: Path) -> None:
    for name in ("monday", "tuesday"):
        (tmp_path / name).mkdir()
    assert kept_token(tmp_path / "monday") != kept_token(tmp_path / "tuesday")


def test_a_token_that_others_could_read_is_no_secret_and_is_replaced(tmp_path: Path) -> None:
    token = kept_token(tmp_path)
    (tmp_path / NAME).chmod(0o640)
    newer = kept_token(tmp_path)
    assert newer != token and kept_token(tmp_path) == newer
    assert stat.S_IMODE((tmp_path / NAME).stat().st_mode) == 0o600


def test_where_files_have_no_modes_the_token_is_the_same_at_every_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a drive of Windows, under WSL or in a container: chmod does nothing, and everything is 0777."""
    real = os.fstat

    def without_modes(descriptor: int) -> os.stat_result:
        return os.stat_result((real(descriptor).st_mode | 0o777, *real(descriptor)[1:]))

    monkeypatch.setattr(os, "fstat", without_modes)
    assert kept_secret(tmp_path / NAME, replace=False) == kept_secret(tmp_path / NAME, replace=False) != ""
    assert kept_token(tmp_path) == kept_token(tmp_path)


@pytest.mark.parametrize("content", [b"", b"short", b"two words that are long enough", b"\xff\x00" * 20, b"a" * 4000])
def test_a_file_that_holds_no_token_is_replaced(tmp_path: Path, content: bytes) -> None:
    (tmp_path / NAME).write_bytes(content)
    (tmp_path / NAME).chmod(0o600)
    token = kept_token(tmp_path)
    assert len(token) >= 20 and kept_token(tmp_path) == token


def test_a_link_to_another_file_is_neither_followed_nor_written_through(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("a-token-of-somebody-else")
    elsewhere.chmod(0o600)
    (tmp_path / NAME).symlink_to(elsewhere)
    assert kept_token(tmp_path) != "a-token-of-somebody-else" == elsewhere.read_text()
    assert not (tmp_path / NAME).is_symlink()


def test_a_token_that_somebody_chose_is_kept(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text("correct-horse-battery\n")
    (tmp_path / NAME).chmod(0o600)
    assert kept_token(tmp_path) == "correct-horse-battery"


def test_a_place_where_no_file_can_be_is_told(tmp_path: Path) -> None:
    (tmp_path / NAME).mkdir()
    with pytest.raises(BadDataFolder, match=r"cannot keep the admin token in .*admin-token"):
        with_kept_token(Settings(data=tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == [NAME], "nothing is left beside it"


def test_two_servers_that_start_at_once_in_a_fresh_folder_have_one_token(tmp_path: Path) -> None:
    for number in range(20):
        folder = tmp_path / str(number)
        folder.mkdir()
        with ThreadPoolExecutor(8) as threads:
            made = list(threads.map(lambda _, folder=folder: kept_token(folder), range(8)))
        assert set(made) == {kept_token(folder)}
        assert [path.name for path in folder.iterdir()] == [NAME]
