"""`movingout recordings list`, `failures` and `recover` where nothing is found: they say where there is something."""

from pathlib import Path

import pytest

from movingout.recordings import finalise
from movingout.server.cli import main
from tests.recordings.support import record


def test_list_names_the_folders_below_that_have_recordings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing had been recorded yet, it said."""
    finalise(record(tmp_path / "grid" / "recordings", ticks=2)[0])
    assert main(["recordings", "list", str(tmp_path / "grid")]) == 0
    said = capsys.readouterr().out
    assert "; 1 below it, in " + str(tmp_path / "grid" / "recordings") in said and "yet" not in said


def test_failures_names_the_folders_below_that_have_recordings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """There were none, it said; their verdicts lie in their own folder."""
    below = tmp_path / "grid" / "recordings"
    record(tmp_path / "grid" / "running", ticks=2)  # which may still be played
    assert main(["recordings", "failures", str(tmp_path / "grid")]) == 2
    assert f"no finished recordings in {tmp_path / 'grid'}; name a folder with" in capsys.readouterr().err
    finalise(record(below, ticks=2)[0])
    assert main(["recordings", "failures", str(tmp_path / "grid")]) == 2
    said = (
        f"no finished recordings in {tmp_path / 'grid'} itself, but 1 below it, in {below}; name one of these folders"
    )
    assert said in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert main(["recordings", "failures", str(tmp_path / "empty")]) == 2
    assert f"no finished recordings in {tmp_path / 'empty'}; name a folder with" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["list", "recover"])
def test_a_data_folder_that_is_not_there_is_no_empty_one(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recordings", command, "--data", str(tmp_path / "dat")]) == 2
    assert f"there is no folder {tmp_path / 'dat'}" in capsys.readouterr().err


def test_recover_names_a_file_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "zero.mcap").touch()
    assert main(["recordings", "recover", str(tmp_path / "zero.mcap")]) == 2
    assert capsys.readouterr().err.count("zero.mcap") == 1
