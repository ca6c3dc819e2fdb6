"""What root makes in a data folder belongs to whom the folder belongs, so that the server can use it."""

import os
from pathlib import Path

import pytest

from movingout.study.data.ownership import make_file, make_folder
from movingout.study.data.study_folder import StudyFolder
from tests.study.support import study

SERVER = 12345
only_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root makes what belongs to others")


def owners(folder: Path) -> dict[str, int]:
    """Who has what is in a folder, by path from there."""
    return {str(path.relative_to(folder)): path.stat().st_uid for path in sorted(folder.rglob("*"))}


@only_root
def test_folders_and_the_lock_belong_to_whom_the_data_folder_belongs(tmp_path: Path) -> None:
    os.chown(tmp_path, SERVER, SERVER)
    folder = StudyFolder(study(), tmp_path)
    with folder.exclusive():
        pass
    own = f"studies/{folder.study.id}"
    assert owners(tmp_path) == dict.fromkeys(("studies", own, f"{own}/serving.lock"), SERVER)


@only_root
def test_what_is_there_stays_whose_it_is(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "file").write_text("kept")
    os.chown(tmp_path / "kept", SERVER, SERVER)
    make_folder(tmp_path / "kept")
    make_file(tmp_path / "kept" / "file")
    make_folder(tmp_path / "mine" / "too")
    assert owners(tmp_path) == {"kept": SERVER, "kept/file": 0, "mine": 0, "mine/too": 0}
    assert (tmp_path / "kept" / "file").read_text() == "kept"


def test_a_file_in_the_place_of_a_folder_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="exists"):
        make_folder(tmp_path / "file")
    with pytest.raises(OSError):
        make_folder(tmp_path / "file" / "below")
