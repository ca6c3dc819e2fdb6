"""The bench of training windows."""

from pathlib import Path

import numpy as np
import pytest

from bench import windows
from bench.windows import driven, encoded, main
from movingout.agents.kinds.registry import KINDS
from tests.agents.learning import recorded


def test_rows_are_repeated_until_they_are_as_many_as_in_training(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(windows, "ROWS", 3_000)
    trajectory = driven("SingleRotation", seed=1)
    made, rate = encoded([trajectory], KINDS["dp"].presets["fast"])
    assert len(made) == 3_000 and rate > 0
    assert np.array_equal(made.features[:500], made.features[1000:1500])
    assert np.array_equal(made.features[:500], trajectory.features(0, "aware-v1"))


def test_a_row_for_each_preset_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(windows, "ROWS", 100)
    monkeypatch.setattr(windows, "BATCHES", 1)
    recorded(tmp_path, "one", ticks=9)
    main(["--data", str(tmp_path)])
    shown = capsys.readouterr().out
    assert "Windows of 1 episodes as tensors" in shown
    assert all(preset in shown for preset in ("dp fast", "gru fast", "dp paper")) and "4 x 4" in shown


def test_missing_recordings_are_refused_in_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--data", "nowhere"])
    assert ended.value.code == 2 and "there is no recording at nowhere" in capsys.readouterr().err
