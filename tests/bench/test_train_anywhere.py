"""The command of the whole recipe: its folder, and whose models its steps find there."""

import os
import re
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


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--partners", "C"], "people of C are for tests and never trained with"),
        (
            ["--partners", "greedy"],
            "known are A, B, AB, a family as family:greedy, families, families:without-greedy",
        ),
        (["--partners", "families:without-greddy"], "unknown family 'greddy'; did you mean greedy?"),
        (["--only-evaluate"], "no checkpoint 'bass@any'; there are: none"),
    ],
)
def test_what_would_fail_after_hours_is_refused_at_the_start(
    words: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(MODELS_VARIABLE, "")
    for name in ("run_stages", "anywhere"):
        monkeypatch.setattr(train_anywhere, name, None)
    with pytest.raises(SystemExit, match=re.escape(sentence)):
        train_anywhere.main(["--data", str(tmp_path), *words])
    assert not any(tmp_path.iterdir())
