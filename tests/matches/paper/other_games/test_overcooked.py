"""The sentence about Overcooked-AI."""

import subprocess
import sys
import sysconfig
import venv
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.agents.overcooked.kitchen import is_installed
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import EmptyCell
from movingout.matches.paper.other_games import overcooked
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.published import published_tables
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate
from tests.support import ROOT


def test_a_change_has_the_error_of_both_means() -> None:
    change = overcooked.relative_change(Estimate(100.0, 3.0, 20), Estimate(115.0, 0.0, 20))
    assert change is not None and change.n == 40
    assert change.mean == pytest.approx(0.15) and change.stderr == pytest.approx(0.0345)
    assert overcooked.relative_change(Estimate(0.0, 0.0, 20), Estimate(5.0, 1.0, 20)) is None


def test_without_the_package_the_cell_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overcooked, "is_installed", lambda: False)
    for column in published_tables()["text:overcooked"].columns:
        cell = overcooked.overcooked_row("bass")(column)
        assert isinstance(cell, EmptyCell) and "[overcooked]'" in cell.reason


def test_what_is_gained_is_counted_game_by_game() -> None:
    found = overcooked.scores({"dp": [20.0, 40.0, 60.0], "bass": [40.0, 60.0, 80.0], "augmented": [60.0, 40.0, 20.0]})
    assert set(found) == {"dp_score", "bass_score", "augmented_score", "bass_gain", "augmented_gain"}
    assert found["bass_gain"] == Estimate(20.0, 0.0, 3)
    assert found["augmented_gain"].mean == 0.0 and found["augmented_gain"].stderr == pytest.approx(40.0 / 3.0**0.5)


def test_the_table_has_the_policy_alone_and_with_each_part_of_bass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(overcooked, "is_installed", lambda: True)
    space = Workspace(budget=BUDGETS["smoke"])
    points = {"dp": [20.0, 40.0], "augmented": [40.0, 40.0], "selected": [60.0, 40.0], "bass": [60.0, 60.0]}
    space.keep("overcooked-ablation", {**overcooked.scores(points), "valid_share": Estimate(0.8, 0.02, 400)})
    shown = {row[0]: row[1:-1:2] for row in laid_out(ENTRIES["text:overcooked"], space).rows}
    assert shown["DP"] == ("–", "30.0000 ± 10.0000", "–", "–")
    assert shown["DP + BASS w/o Simulation"][1:] == ("40.0000 ± 0.0000", "10.0000 ± 10.0000", "0.8000 ± 0.0200")
    assert shown["DP + BASS w/o Augmentation"][1:] == ("50.0000 ± 10.0000", "20.0000 ± 20.0000", "–")
    assert shown["DP + BASS"][0].startswith("1.0000 ±") and shown["DP + BASS"][2] == "30.0000 ± 10.0000"


@pytest.mark.parametrize("budget", BUDGETS)
def test_every_budget_says_how_long_a_training_takes(budget: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overcooked, "is_installed", lambda: True)
    (step,) = paper_steps([ENTRIES["text:overcooked"]], Workspace(budget=replace(BUDGETS[budget], trainings=1)))
    assert step.seconds > 0.0


@pytest.mark.slow
@pytest.mark.timeout(1200)  # where the package is not beside ours, it is downloaded first
def test_the_sentence_is_measured_from_nothing(tmp_path: Path) -> None:
    python = sys.executable if is_installed() else _with_the_package(tmp_path / "environment")
    command = [python, "-P", "-m", "movingout.server.cli", "paper", "tables", "text:overcooked"]
    shown = _run([*command, "--budget", "smoke", "-o", str(tmp_path / "out")])
    assert all(f"| {name} |" in shown for name in overcooked.ROWS) and "scripted people" not in shown


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
