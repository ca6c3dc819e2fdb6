"""The command of the whole recipe: its folder, and whose models its steps find there."""

import os
from pathlib import Path

import pytest

from bench import train_anywhere
from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, SHIPPED, model_roots


def test_a_folder_of_its_own_with_models_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(MODELS_VARIABLE, "")
    assert model_roots() == (Path("data/models"), SHIPPED)
    found: list[tuple[Path, ...]] = []
    monkeypatch.setattr(train_anywhere, "run_stages", lambda *words: found.append(model_roots()))
    monkeypatch.setattr(train_anywhere, "_measure", lambda *words: None)
    train_anywhere.main(["--data", str(tmp_path), "--maps", "2"])
    assert found == [(tmp_path / "models", Path("data/models"), SHIPPED)]
    assert os.environ[MODELS_VARIABLE] == str(tmp_path / "models"), "the processes of the steps look there first"
    with pytest.raises(SystemExit, match="was begun with --maps 2, not --maps 3; choose another --data"):
        train_anywhere.main(["--data", str(tmp_path), "--maps", "3"])
    capsys.readouterr()
    train_anywhere.main(["--data", str(tmp_path), "--maps", "2", "--dry-run", "--seeds", "2"])
    assert f"--id bass@any-1 --name 'DP/BASS, any map, seed 1' --data {tmp_path}" in capsys.readouterr().out
