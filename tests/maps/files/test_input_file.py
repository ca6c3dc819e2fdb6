"""Files that people name: whatever they are, there is a sentence and never a wait."""

import os
from pathlib import Path

import pytest

from movingout.maps import MapError, load_map
from movingout.maps.files.input_file import read_input
from movingout.matches.errors import MatchError
from movingout.matches.experiment.grid import read_grid
from movingout.recordings import RecordingError, read_episode
from movingout.recordings.groups import read_groups
from movingout.recordings.storage.index import list_recordings
from movingout.server.cluster.capacity import read_figures
from movingout.server.cluster.errors import ClusterError
from movingout.study.design.study_file import read_study
from movingout.study.errors import StudyError


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    os.mkfifo(tmp_path / "pipe.yaml")
    return tmp_path / "pipe.yaml"


def test_a_pipe_is_no_study_and_no_map(pipe: Path) -> None:
    with pytest.raises(StudyError, match="pipe or a device"):
        read_study(pipe)
    with pytest.raises(MapError, match="pipe or a device"):
        load_map(str(pipe.rename(pipe.with_suffix(".json"))))


def test_a_pipe_among_recordings_holds_nobody_up(tmp_path: Path) -> None:
    for name in ("a.mcap", "b.journal"):
        os.mkfifo(tmp_path / name)
    damaged = list_recordings(tmp_path)[1]
    assert [one.path.name for one in damaged if "pipe or a device" in one.problem] == ["a.mcap"]
    for name in ("a.mcap", "b.journal"):
        with pytest.raises(RecordingError, match="pipe or a device"):
            read_episode(tmp_path / name)


def test_a_pipe_is_no_grid_no_list_of_groups_and_no_figures(pipe: Path) -> None:
    with pytest.raises(MatchError, match="pipe or a device"):
        read_grid(pipe)
    with pytest.raises(RecordingError, match="pipe or a device"):
        read_groups(pipe)
    with pytest.raises(ClusterError, match="pipe or a device"):
        read_figures(pipe)


@pytest.mark.slow
def test_a_name_with_a_nul_a_folder_and_a_deep_document_are_refused_in_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="NUL"):
        read_study(Path("a\0b.yaml"))
    with pytest.raises(StudyError, match="directory"):
        read_study(tmp_path)
    for text in ("[" * 50_000, "a: " + "{b: " * 3_000, "&a [*a]", "\0", "x: !!python/object:os.system {}"):
        (tmp_path / "deep.yaml").write_text(text)
        with pytest.raises(StudyError):
            read_study(tmp_path / "deep.yaml")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "large").write_bytes(b"x" * 1001)
    assert len(read_input(tmp_path / "large", most=1001)) == 1001
    with pytest.raises(OSError, match="more than"):
        read_input(tmp_path / "large", most=1000)
