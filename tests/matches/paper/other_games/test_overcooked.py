"""The sentence about Overcooked-AI."""

import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from movingout.agents.overcooked.kitchen import is_installed
from movingout.matches.paper.cells import EmptyCell
from movingout.matches.paper.other_games import overcooked
from movingout.world.estimates import Estimate
from tests.support import ROOT


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
@pytest.mark.timeout(1200)  # where the package is not beside ours, it is downloaded first
def test_the_sentence_is_measured_from_nothing(tmp_path: Path) -> None:
    python = sys.executable if is_installed() else _with_the_package(tmp_path / "environment")
    command = [python, "-P", "-m", "movingout.server.cli", "paper", "tables", "text:overcooked"]
    shown = _run([*command, "--budget", "smoke", "-o", str(tmp_path / "out")])
    assert "DP + BASS" in shown and "scripted people" not in shown


def _with_the_package(folder: Path) -> str:
    """The Python of an environment that has what this one has, and the package."""
    venv.create(folder, with_pip=True)
    mine, theirs = sysconfig.get_path("purelib"), sysconfig.get_path("purelib", vars={"base": str(folder)})
    (Path(theirs) / "mine.pth").write_text(f"import site; site.addsitedir({mine!r})\n", encoding="utf-8")
    python = str(folder / "bin" / "python")
    _run([python, "-m", "pip", "install", "--quiet", "-c", str(ROOT / "constraints.txt"), "overcooked-ai", "pandas"])
    return python


def _run(command: list[str]) -> str:
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-4000:]
    return ran.stdout
