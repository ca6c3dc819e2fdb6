"""Every table that can be made is made, from nothing, with the smallest budget.

On three maps and in 12 ticks hardly anything can happen: this tests that steps run, not what their numbers mean. AC has
no value, since nothing is carried together.
"""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.paper import budgets, cells, data_sets
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.server.cli import main

MAPS = ("HandOff", "DistancePriority", "SingleRotation")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """The budget smoke on three maps, a second each; two variants, so that there are paths to compare."""
    monkeypatch.setitem(budgets.BUDGETS, "smoke", replace(budgets.BUDGETS["smoke"], ticks=12, variants=2))
    for module in (cells, data_sets):
        monkeypatch.setattr(module, "map_names", lambda: MAPS)


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_all_tables_and_figures_are_made_from_nothing_and_a_second_time_nothing_is_left_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    command = ["-o", str(out), "--budget", "smoke", "--workers", "2"]
    without_extra = [entry.label for entry in ENTRIES.values() if entry.extra and not entry.runnable]
    assert main(["paper", "tables", "all", *command]) == (1 if without_extra else 0)
    assert all(f"{label} was not made" in capsys.readouterr().err for label in without_extra)
    assert main(["paper", "figures", "all", *command]) == 0
    capsys.readouterr()
    for entry in ENTRIES.values():
        if entry.runnable:
            folder = out / ("figures" if entry.kind == "figure" else "tables")
            files = [folder / f"{entry.label.replace(':', '_')}.{ending}" for ending in ("md", "tex", "html")]
            assert all(file.exists() for file in files), entry.label
            assert "not measured" not in files[0].read_text(encoding="utf-8"), entry.label
    picture = (out / "figures" / "fig_results_t2.svg").read_text(encoding="utf-8")
    assert picture.count('<rect class="ours"') == 15, "AC has no value where nobody carries anything together"
    before = {path: path.stat().st_mtime_ns for path in (out / "data").rglob("*") if path.is_file()}
    assert main(["paper", "tables", "tab:ablation", *command]) == 0
    assert "+ Full BASS" in capsys.readouterr().out
    assert {path: path.stat().st_mtime_ns for path in before} == before
    monkeypatch.chdir(out)
    groups = [set(Workspace(budget=budgets.BUDGETS["smoke"]).episodes(name)) for name in "ab"]
    assert all(groups) and not groups[0] & groups[1]
    assert main(["paper", "tables", "tab:ablation", *command, "--seed", "1"]) == 2
    assert "was begun with seed 0" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_the_harder_protocols_are_made_too(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["-o", str(out), "--budget", "smoke", "--evaluation", "held-out", "--groups", "style", "--trainings", "2"]
    assert main(["paper", "tables", "tab:tcl_results", *command]) == 0
    page = (out / "tables" / "tab_tcl_results.md").read_text(encoding="utf-8")
    assert "not measured" not in page and "(trainings ±" in page
    assert "two styles of play" in page and "share no combination of size and shape" in page


@pytest.mark.parametrize("label", [entry.label for entry in ENTRIES.values() if not entry.runnable])
def test_what_nothing_makes_says_why(label: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "tables", label, "-o", str(tmp_path / "out")]) == 2
    assert f"{label} is not made by this command: " in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
