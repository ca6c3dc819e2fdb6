"""`movingout train`: copies of recordings among the data, and a run folder in which another process trains."""

import json
import shutil
from pathlib import Path

import pytest

pytest.importorskip("torch")

from movingout.agents.training.run_folder import held
from movingout.server.cli import main
from tests.agents.learning import recorded

TINY = ["--updates", "2", "--batch", "8", "--width", "8", "--depth", "1"]


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    for number in range(2):
        recorded(tmp_path / "recordings", f"e{number}", ticks=10, seed=number)
    return tmp_path / "recordings"


def test_copies_of_recordings_are_told_of(recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(recordings, tmp_path / "backup")
    files = len(list(recordings.iterdir()))
    command = ["train", "mlp", str(recordings), str(tmp_path / "backup"), "--id", "mlp@tiny", "--data", str(tmp_path)]
    assert main([*command, *TINY, "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["episodes"] == files
    assert f"movingout: {files} copies left out, of recordings that are there, too" in shown.err


def test_a_training_that_runs_is_left_alone(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]
    folder = tmp_path / "runs" / "mlp-tiny"
    with held(folder):
        assert main(command) == 2
    assert "another process trains in" in capsys.readouterr().err
    assert [path.name for path in folder.iterdir()] == [".lock"]
    assert main(command) == 0
    with held(folder):
        pass
