"""What root makes belongs to whom its folder belongs, so that a server that runs as somebody else can use it."""

import os
from pathlib import Path

import pytest

from movingout.maps.files.output_file import draft_of
from movingout.maps.files.ownership import make_file, make_folder
from tests.owners import SERVER, only_root, owners


@only_root
def test_what_is_made_belongs_to_whom_its_folder_belongs(tmp_path: Path) -> None:
    os.chown(tmp_path, SERVER, SERVER)
    make_folder(tmp_path / "new" / "below")
    make_file(tmp_path / "new" / "below" / "file")
    with draft_of(tmp_path / "written") as draft:
        draft.write_text("whole")
    assert owners(tmp_path) == dict.fromkeys(("new", "new/below", "new/below/file", "written"), SERVER)


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
