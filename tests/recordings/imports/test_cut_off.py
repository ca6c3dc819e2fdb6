"""An import that was killed, or whose disk was full, is made whole by importing once more."""

import json
from pathlib import Path

import pytest

from movingout.recordings import EpisodeWriter, finalise, read_episode
from movingout.recordings.imports.convert import import_source
from movingout.recordings.imports.sources import TrajectoryFile, read
from movingout.recordings.official_format import recorder_steps
from movingout.recordings.storage.finished import recover
from tests.recordings.support import plain, record


@pytest.fixture
def source(tmp_path: Path) -> TrajectoryFile:
    journal, _ = record(tmp_path / "ours", ticks=8, map_name="LeftRight")
    path = tmp_path / "LeftRight_20250101.json"
    path.write_text(json.dumps([recorder_steps(read_episode(finalise(journal)))]), encoding="utf-8")
    return read(path)[0]


def cut_off(source: TrajectoryFile, folder: Path, ticks: int) -> EpisodeWriter:
    """The journal of an import that has come so far, in a folder of its own."""
    whole = read_episode(folder.parent / "whole" / import_source(source, folder.parent / "whole", "salt").recording)
    writer = EpisodeWriter.create(folder, whole.header, whole.initial)
    for tick in whole.ticks[:ticks]:
        writer.tick(tick)
    return writer


@pytest.mark.parametrize("ticks", [3, 8])
@pytest.mark.parametrize("recovered", [False, True])
def test_what_was_cut_off_is_imported_anew(source: TrajectoryFile, tmp_path: Path, ticks: int, recovered: bool) -> None:
    """It was refused for its journal, and once that was recovered, a part passed for the whole."""
    folder = tmp_path / "in"
    cut_off(source, folder, ticks).abandon()
    if recovered:
        assert [one.ticks for one in recover(folder)] == [ticks]
    report = import_source(source, folder, "salt")
    assert (report.problem, report.unchanged) == ("", "")
    (path,) = folder.iterdir()
    again, whole = (read_episode(one) for one in (path, tmp_path / "whole" / path.name))
    assert again.complete and plain(again.states) == plain(whole.states)
    assert import_source(source, folder, "salt").unchanged == "imported before; nothing changed"


def test_what_another_process_is_importing_is_left_to_it(source: TrajectoryFile, tmp_path: Path) -> None:
    writer = cut_off(source, tmp_path / "in", 3)
    report = import_source(source, tmp_path / "in", "salt")
    assert "is being written by another process" in report.problem
    assert writer.path.exists()
    writer.abandon()
