"""Files that are written whole or not at all."""

from pathlib import Path

import pytest

from movingout.maps.errors import MapError
from movingout.maps.files.output_file import draft_of, write_output


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
