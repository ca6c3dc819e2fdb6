"""Lists of generated maps that a scripted pair solves."""

from pathlib import Path

import pytest

from movingout.agents.data import proving
from movingout.maps import MapError, MapSpec
from movingout.maps.generated.names import read_name
from movingout.maps.generated.proved import read_table
from movingout.maps.selection import selected_maps


def solved_if_even(spec: MapSpec) -> int | None:
    seed = read_name(spec.name)[1]
    return 100 + seed % 1000 if seed % 2 == 0 else None


def test_a_list_is_continued_and_keeps_what_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proving, "ticks_to_deliver", solved_if_even)
    monkeypatch.setattr(proving, "load_map", lambda name: MapSpec(name, "", 0, "awareness", "", (), (), (), ()))  # type: ignore[arg-type]
    path = tmp_path / "maps.txt"
    tried = list(proving.prove("validation", path, 2, workers=1))
    assert len(tried) == 12  # four seeds of each mode
    table = read_table(path)
    assert [name for name in table if "awareness" in name] == ["generated:awareness:10000", "generated:awareness:10002"]
    assert table["generated:awareness:10002"] == 102
    list(proving.prove("validation", path, 3, workers=1))
    assert list(read_table(path))[:6] == list(table)
    assert len(read_table(path)) == 9
    assert not list(proving.prove("validation", path, 3, workers=1)), "nothing is left to do"
    assert selected_maps(f"@{path}")[:2] == ["generated:coordination:10000", "generated:awareness:10000"]
    assert selected_maps(f"@{path}:1") == ["generated:coordination:10000"]
    with pytest.raises(MapError, match="has 1 to 9 maps, not 10"):
        selected_maps(f"@{path}:10")
    with pytest.raises(MapError, match="has generated:coordination:10000, which is not of generated:test"):
        list(proving.prove("test", path, 3, workers=1))


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "maps.txt"
    path.write_text("generated:awareness:1 100\nhello\n")
    with pytest.raises(MapError, match="line 2: a name and a number of ticks are needed, not 'hello'"):
        read_table(path)


@pytest.mark.slow
def test_the_first_listed_maps_are_solved_in_the_listed_time() -> None:
    from movingout.maps import load_map
    from movingout.maps.generated.proved import proved_maps, ticks_needed

    for name in proved_maps("test", 6):
        assert proving.ticks_to_deliver(load_map(name)) == ticks_needed(name)


def test_before_anything_is_played_a_place_that_cannot_be_written_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(folder: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(proving, "ticks_to_deliver", lambda spec: pytest.fail("it was played"))
    monkeypatch.setattr(Path, "mkdir", denied)
    with pytest.raises(MapError, match=r"cannot write .*maps.txt: Permission denied$"):
        next(proving.prove("validation", tmp_path / "new" / "maps.txt", 2, workers=1))


def test_a_disk_that_is_full_is_answered_with_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path, content: object, **_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(proving, "ticks_to_deliver", solved_if_even)
    monkeypatch.setattr(Path, "write_bytes", full)
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(MapError, match=r"cannot write .*maps.txt: No space left on device$"):
        list(proving.prove("validation", tmp_path / "maps.txt", 1, workers=1))
