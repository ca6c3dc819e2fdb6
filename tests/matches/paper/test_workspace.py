"""A folder of tables has agents and measurements of its own."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, own_models
from movingout.matches.commands import paper
from movingout.matches.paper import workspace
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.rows.measurements import noise_validity
from movingout.matches.paper.rows.reinforced import behaviour
from movingout.matches.paper.workspace import Workspace, inside
from movingout.server.cli import main
from movingout.world.estimates import Estimate


def test_a_folder_of_tables_plays_its_own_agents_and_not_those_that_a_variable_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`docs/matches.md` has people name the agents of another folder of tables for other commands."""
    monkeypatch.setenv(MODELS_VARIABLE, str(tmp_path / "elsewhere"))
    looked: list[str] = []
    monkeypatch.setattr(paper, "carry_out", lambda steps, space, where: looked.append(own_models()))
    monkeypatch.setattr(paper, "write_page", lambda *_: looked.append(own_models()))
    out = str(tmp_path / "out")
    assert main(["paper", "tables", "mappo_parameters", "--budget", "smoke", "-o", out]) == 0
    assert main(["paper", "page", "page.md", "-o", out]) == 0
    assert looked == [str((tmp_path / "out/data/models").resolve())] * 2
    with pytest.raises(FileNotFoundError), inside(tmp_path / "nowhere"):
        pass
    assert os.environ[MODELS_VARIABLE] == str(tmp_path / "elsewhere"), "for what follows in the same process"


def test_a_dry_run_does_not_look_into_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "begun").mkdir()
    monkeypatch.chdir(tmp_path / "begun")
    asked = ["paper", "tables", "mappo_parameters", "--budget", "smoke"]
    assert main([*asked, "-o", "."]) == 0
    assert main([*asked, "--seed", "1", "--dry-run", "-o", "../new"]) == 0, capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_numbers_of_other_versions_or_of_fewer_episodes_are_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space, more = (Workspace(budget=replace(BUDGETS["smoke"], seeds=seeds)) for seeds in (1, 20))
    cell = behaviour("mappo-{}")(PublishedColumn(1, "map_11_first_grasp_s"))
    assert isinstance(cell, MeasuredCell)
    one, numbers = cell.measurement, {"map_11_first_grasp_s": Estimate(3.0, 0.1, 8)}
    one = replace(one, perform=lambda space, training: numbers)
    one.measure(0, space)
    assert one.measured(0, space) == numbers and one.measured(0, more) is None
    file = Path(f"data/measured/{one.name}.json")
    earlier = {key: value for key, value in json.loads(file.read_text()).items() if key in ("weights", "numbers")}
    file.write_text(json.dumps(earlier), encoding="utf-8")
    assert one.measured(0, more) == numbers, "of before that was noted"
    one.measure(0, more)
    assert one.measured(0, space) == numbers, "in more episodes than are wanted"
    monkeypatch.setattr(workspace, "versions", lambda: {"movingout": "next", "pymunk": "next"})
    assert one.measured(0, space) is None


def test_what_was_measured_in_other_numbers_of_states_is_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run with more states took the numbers of the run before."""
    monkeypatch.chdir(tmp_path)
    fewer, more = (Workspace(budget=replace(BUDGETS["smoke"], states=states)) for states in (20, 40))
    numbers = {"valid_share": Estimate(0.5, 0.1, 100)}
    one = replace(noise_validity("0.2").measurement, perform=lambda space, training: numbers)
    one.measure(0, fewer)
    assert one.measured(0, fewer) == numbers and one.measured(0, more) is None
    one.measure(0, more)
    assert one.measured(0, more) == numbers and one.measured(0, fewer) is None
    file = Path(f"data/measured/{one.name}.json")
    earlier = {key: value for key, value in json.loads(file.read_text()).items() if key != "samples"}
    file.write_text(json.dumps(earlier), encoding="utf-8")
    assert one.measured(0, fewer) == numbers, "of before that was noted"


@pytest.mark.parametrize("text", ["", "[]", '{"numbers": [', '{"numbers": {"valid_share": null}}'])
def test_what_a_power_failure_left_of_a_measurement_is_measured_again(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space, one = Workspace(budget=BUDGETS["smoke"]), noise_validity("0.2").measurement
    one = replace(one, perform=lambda space, training: {"valid_share": Estimate(0.5, 0.1, 20)})
    one.measure(0, space)
    (tmp_path / f"data/measured/{one.name}.json").write_text(text, encoding="utf-8")
    assert one.measured(0, space) is None
    one.measure(0, space)
    assert one.measured(0, space) == {"valid_share": Estimate(0.5, 0.1, 20)}
