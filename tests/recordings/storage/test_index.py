"""The index: as fast as a database, as true as the files."""

import os
import shutil
from pathlib import Path

import pytest

from movingout.recordings import RecordingError, finalise
from movingout.recordings.storage import index as index_module
from movingout.recordings.storage.index import INDEX_NAME, Filter, list_recordings, path_of
from movingout.recordings.storage.listing import Summary, read_summary
from tests.recordings.support import begin, play, record


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, map_name in (("a", "HandOff"), ("b", "LeftRight"), ("c", "LeftRight")):
        finalise(record(tmp_path, ticks=3, episode_id=name, map_name=map_name)[0])
    return tmp_path


def names(folder: Path, wanted: Filter | None = None) -> set[str]:
    return {entry.id for entry in list_recordings(folder, wanted)[0]}


def test_a_listed_recording_equals_the_one_read_from_its_file(folder: Path) -> None:
    for _ in range(2):
        found, unreadable = list_recordings(folder)
        assert sorted(found, key=lambda entry: entry.id) == [read_summary(folder / f"{n}.mcap") for n in "abc"]
        assert unreadable == []


def test_files_are_opened_once_and_again_only_when_they_change(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []

    def spy(path: Path) -> Summary:
        opened.append(path.name)
        return read_summary(path)

    monkeypatch.setattr(index_module, "read_summary", spy)
    list_recordings(folder)
    assert sorted(opened) == ["a.mcap", "b.mcap", "c.mcap"]
    opened.clear()
    list_recordings(folder, Filter(map="LeftRight"))
    assert opened == []
    os.utime(folder / "b.mcap", ns=(1, 1))
    list_recordings(folder)
    assert opened == ["b.mcap"]


def test_what_is_added_removed_or_replaced_shows_at_the_next_look(folder: Path) -> None:
    assert names(folder) == {"a", "b", "c"}
    (folder / "a.mcap").unlink()
    finalise(record(folder, ticks=2, episode_id="d")[0])
    (folder / "c.mcap").write_bytes(b"broken")
    found, unreadable = list_recordings(folder)
    assert {entry.id for entry in found} == {"b", "d"}
    assert [entry.path.name for entry in unreadable] == ["c.mcap"]


def test_a_journal_is_listed_as_it_stands(folder: Path) -> None:
    writer, played = begin(folder, episode_id="running")
    for ticks in (1, 2):
        play(writer, played, 1)
        (entry,) = [entry for entry in list_recordings(folder)[0] if entry.id == "running"]
        assert (entry.ticks, entry.outcome, entry.complete) == (ticks, "interrupted", False)
    assert "running" not in {entry.id for entry in list_recordings(folder, running=False)[0]}
    writer.abandon()


@pytest.mark.parametrize("content", [b"", b"this is no database" * 100])
def test_a_broken_index_is_rebuilt(folder: Path, content: bytes) -> None:
    (folder / INDEX_NAME).write_bytes(content)
    assert names(folder) == {"a", "b", "c"}
    assert names(folder, Filter(map="HandOff")) == {"a"}


def test_an_index_of_another_version_is_rebuilt(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert names(folder) == {"a", "b", "c"}
    monkeypatch.setattr(index_module, "_VERSION", 2)
    assert names(folder) == {"a", "b", "c"}


def test_a_folder_that_takes_no_index_lists_all_the_same(folder: Path) -> None:
    (folder / INDEX_NAME).mkdir()
    assert names(folder) == {"a", "b", "c"}


def test_text_in_a_filter_is_never_sql(folder: Path) -> None:
    assert names(folder, Filter(map="x' OR '1'='1")) == set()
    assert names(folder, Filter(agent="scripted", study="pilot", since="2026-01-01")) == {"a", "b", "c"}


def test_a_name_that_is_not_utf8_is_listed_as_unreadable_and_keeps_nobody_from_the_others(folder: Path) -> None:
    """One such file ended every listing in a traceback: neither SQLite nor JSON takes its name."""
    for suffix in (".mcap", ".mcap.journal"):
        shutil.copy(folder / "a.mcap", folder / os.fsdecode(b"caf\xe9" + suffix.encode()))
    found, unreadable = list_recordings(folder)
    assert {entry.id for entry in found} == {"a", "b", "c"}
    assert sorted(entry.path.name for entry in unreadable) == [r"caf\xe9.mcap", r"caf\xe9.mcap.journal"]
    assert all(entry.problem.endswith("its name is not UTF-8 text; rename it") for entry in unreadable)


def test_a_folder_whose_name_is_not_utf8_is_listed(folder: Path) -> None:
    odd = folder / os.fsdecode(b"caf\xe9")
    odd.mkdir()
    shutil.copy(folder / "a.mcap", odd)
    (odd / "broken.mcap").symlink_to("nowhere")
    found, unreadable = list_recordings(odd)
    assert [entry.path for entry in found] == [odd / "a.mcap"]
    assert [entry.path for entry in unreadable] == [odd / "broken.mcap"]


def test_an_episode_is_found_by_its_id_whatever_its_file_is_called(folder: Path) -> None:
    """It was listed by its id, which opened nothing."""
    renamed = (folder / "a.mcap").rename(folder / "mine.mcap")
    assert path_of(folder, "a") == renamed and path_of(folder, "b") == folder / "b.mcap"
    renamed = renamed.rename(folder / "yours.mcap")
    assert path_of(folder, "a") == renamed
    renamed.unlink()
    with pytest.raises(RecordingError, match="there is no recording 'a'"):
        path_of(folder, "a")
    with pytest.raises(RecordingError, match="there is no recording 'a'"):
        path_of(folder / "nowhere", "a")
