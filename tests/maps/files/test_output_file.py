"""Files that are written whole or not at all."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from movingout.maps.errors import MapError
from movingout.maps.files.output_file import check_output, draft_of, write_output


def test_a_file_replaces_an_older_one(tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    write_output(path, b"old")
    write_output(path, b"new")
    assert path.read_bytes() == b"new" and list(tmp_path.iterdir()) == [path]


def test_what_was_there_stays_when_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "map.json"
    path.write_bytes(b"old")

    def half(draft: Path, content: bytes) -> int:
        draft.write_text("n")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    with pytest.raises(MapError, match=r"cannot write .*map.json: No space left on device$"):
        write_output(path, b"new")
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_a_draft_is_gone_whatever_goes_wrong(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no table"), draft_of(tmp_path / "results.parquet") as draft:
        draft.write_bytes(b"half")
        raise ValueError("no table")
    assert list(tmp_path.iterdir()) == []


def test_drafts_of_crashed_programs_are_removed_and_no_others(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        ended.wait()
    dead, living, path = ended.pid, os.getppid(), tmp_path / "map.json"
    left = tmp_path / f".map.json.{dead}"
    kept = [
        tmp_path / f".map.json.{living}",
        tmp_path / f".other.json.{dead}",
        tmp_path / f"map.json.{dead}",
        tmp_path / ".map.json.bak",
        tmp_path / ".map.json.99999999999999999999",
    ]
    for draft in (left, *kept):
        draft.write_text("half")
        os.utime(draft, (1e9, 1e9))
    write_output(path, b"whole")
    assert sorted(tmp_path.iterdir()) == sorted([*kept, path])
    left.write_text("half")
    write_output(path, b"whole")
    assert left.exists(), "it may be that of a program on another machine, which has the same folder"


def test_it_is_told_beforehand_whether_a_file_can_be_written(tmp_path: Path) -> None:
    check_output(tmp_path / "new" / "list.txt")
    assert list(tmp_path.rglob("*")) == [tmp_path / "new"], "the folder is made, the file is not"
    with pytest.raises(MapError, match=r"cannot write .*new: Is a directory$"):
        check_output(tmp_path / "new")
    (tmp_path / "file").touch()
    with pytest.raises(MapError, match=r"cannot write .*list.txt: "):
        check_output(tmp_path / "file" / "list.txt")
