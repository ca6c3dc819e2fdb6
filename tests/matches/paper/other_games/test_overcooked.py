"""The sentence about Overcooked-AI."""

from pathlib import Path

import pytest

from movingout.agents.overcooked.kitchen import is_installed
from movingout.matches.paper.cells import EmptyCell
from movingout.matches.paper.other_games import overcooked
from movingout.server.cli import main
from movingout.world.estimates import Estimate


def test_a_change_has_the_error_of_both_means() -> None:
    change = overcooked.relative_change(Estimate(100.0, 3.0, 20), Estimate(115.0, 0.0, 20))
    assert change is not None and change.n == 40
    assert change.mean == pytest.approx(0.15) and change.stderr == pytest.approx(0.0345)
    assert overcooked.relative_change(Estimate(0.0, 0.0, 20), Estimate(5.0, 1.0, 20)) is None


def test_without_the_package_the_cell_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overcooked, "is_installed", lambda: False)
    cell = overcooked.overcooked_change()
    assert isinstance(cell, EmptyCell) and "'.[overcooked]'" in cell.reason


@pytest.mark.slow
@pytest.mark.skipif(not is_installed(), reason="the extra overcooked is not installed")
def test_the_sentence_is_measured_from_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "tables", "text:overcooked", "--budget", "smoke", "-o", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "DP + BASS" in shown and "scripted people" not in shown
