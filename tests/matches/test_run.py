"""Matches that are played by one call, and what is said before they begin; `test_grid_run.py` has grids."""

import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.maps import load_map, map_to_json
from movingout.matches import MatchError, play, run_grid
from movingout.matches.experiment.grid import Grid
from movingout.matches.match import Match
from movingout.server.cli import main
from tests.agents.llm.stand_in import said, stand_in
from tests.matches.support import HERE, small_grid

pytestmark = pytest.mark.slow


def test_the_example_of_play_runs(capsys: pytest.CaptureFixture[str]) -> None:
    lines = (inspect.getdoc(play) or "").splitlines()
    example = "\n".join(line[4:] for line in lines if line.startswith("    "))
    exec("import movingout\n" + example.replace("episodes=5", "episodes=2, ticks=2, workers=1"))
    assert capsys.readouterr().out == "[0.0, 0.0]\n"


def test_a_map_with_more_than_an_agent_sees_is_refused_before_anything_is_played(tmp_path: Path) -> None:
    document = map_to_json(load_map("DistancePriority")) | {"name": "Five", "number": 0}
    path = tmp_path / "five.json"
    path.write_text(json.dumps(document | {"goals": document["goals"] * 5}))
    sentence = re.escape(f"dp@all cannot play {path}: the layout aware-v1 has 4 slots for goals; Five has ")
    with pytest.raises(AgentError, match=sentence):
        play("dp@all", "idle", str(path), ticks=2)
    grid = Grid.model_validate({"name": "x", "agents": ["idle", "dp@all"], "maps": [str(path)], "seeds": 1})
    with pytest.raises(AgentError, match=sentence):
        run_grid(grid, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"episodes": 1.5}, "episodes is a whole number from 1 to 1000000, not 1.5"),
        ({"ticks": 0}, "ticks is a whole number from 1 to 36000, not 0"),
        ({"ticks": 10**9}, "ticks is a whole number from 1 to 36000, not 1000000000"),
        ({"seed": 2**63}, "seed is a whole number from 0 to 9007199254740991, not 9223372036854775808"),
        ({"challenge": 3}, "challenge is a whole number from 1 to 2, not 3"),
    ],
)
def test_numbers_that_cannot_be_are_refused(numbers: dict[str, Any], sentence: str) -> None:
    """play(ticks=0) played a tick, and a seed above 2**63 ended its export in a traceback."""
    with pytest.raises(MatchError, match=re.escape(sentence)):
        play("idle", "idle", workers=1, **numbers)


def test_numbers_of_numpy_are_numbers() -> None:
    """`challenge=np.int64(2)` ended in `TypeError: Object of type int64 is not JSON serializable`."""
    one, two = map(np.int64, (1, 2))
    [result] = play("idle", "idle", seed=two, ticks=two, episodes=one, challenge=two, workers=1)  # type: ignore[arg-type]
    assert result.match == Match("HandOff", "idle", "idle", 2, 2, 2)


def test_a_file_where_one_stands_does_not_take_the_place_of_a_library_in_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy.py").write_text("raise ImportError('not the numpy you want')\n")
    monkeypatch.chdir(tmp_path)
    (result,) = play("idle", "idle", ticks=1, workers=1)
    assert result.ending == "time", result.failure


def test_an_agent_that_asks_the_keyboard_fails_at_once_and_takes_no_jobs() -> None:
    with pytest.warns(match="1 of 1 matches failed"):
        (result,) = play(f"{HERE}:Asking", "idle", ticks=1, workers=1)
    assert result.failure.startswith(f"blue ({HERE}:Asking) raised EOFError in act() at tick 0"), result.failure


def test_a_map_file_with_faults_is_warned_about_as_commands_say_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """TCR below 1 was read as the failure of the agents."""
    corner = [{"x0": -1.2, "y0": -1.19, "x1": -1.19, "y1": -1.2}]
    name = str(tmp_path / "corner.json")
    Path(name).write_text(json.dumps(map_to_json(load_map("Simple")) | {"name": "Corner", "goals": corner}))
    grid = small_grid(agents=["idle"], partners=["idle"], maps=[name], seeds=1, ticks=2)
    fault = "corner.json cannot be played as it should: "
    for call in (
        lambda: play("idle", "idle", name, ticks=2, workers=1),
        lambda: run_grid(grid, tmp_path / "out", workers=1),
    ):
        with pytest.warns(UserWarning, match=fault) as warned:
            call()
        assert {Path(one.filename).name for one in warned} == {"test_run.py"}
    (tmp_path / "grid.yaml").write_text(f"name: g\nagents: [idle]\nmaps: [{name}]\nseeds: 1\nticks: 2\n")
    assert main(["match", "grid", str(tmp_path / "grid.yaml"), "--out", str(tmp_path / "g"), "--workers", "1"]) == 0
    assert capsys.readouterr().err.count("cannot be played as it should") == 1


def test_a_language_model_that_no_match_waits_for_is_warned_about_as_commands_say_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its row had the fallback's score, and nothing said so."""
    caution = "does not wait for its answers, and a match without people outruns them: add wait=yes."
    with stand_in(lambda _: said("hm")) as server:
        model = f"llm:model=m,url={server.url}"
        grid = small_grid(agents=[model], partners=["idle"], maps=["HandOff"], seeds=1, ticks=2)
        for call in (
            lambda: play("idle", f"late:agent={model.replace(',', ';')}", ticks=2, workers=1),
            lambda: run_grid(grid, tmp_path / "out", workers=1),
        ):
            with pytest.warns(UserWarning, match=caution) as warned:
                call()
            assert {Path(one.filename).name for one in warned} == {"test_run.py"}
        (tmp_path / "grid.yaml").write_text(f"name: g\nagents: ['{model}']\nmaps: [HandOff]\nseeds: 1\nticks: 2\n")
        command = ["match", "grid", str(tmp_path / "grid.yaml"), "--out", str(tmp_path / "g"), "--workers", "1"]
        assert main(command) == 0
    assert capsys.readouterr().err.count(caution) == 1


@pytest.mark.parametrize("agent", ["__main__:Mine", "late:agent=__main__:Mine", "__main__:Mine:lag=2"])
def test_a_class_of_the_notebook_is_refused_by_its_name_before_anything_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, agent: str
) -> None:
    """It was found here and not in the workers: every match failed."""
    monkeypatch.setattr(sys.modules["__main__"], "Mine", lambda: load_agent("idle"), raising=False)
    with pytest.raises(AgentError, match="give the class itself to play"):
        play(agent, "idle", "HandOff", ticks=2)
    grid = Grid.model_validate({"name": "x", "agents": [agent], "maps": ["HandOff"], "seeds": 1})
    with pytest.raises(MatchError, match="or put it into a file of its own"):
        run_grid(grid, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_play_returns_results_in_the_order_of_seeds() -> None:
    results = play(f"{HERE}:Wanderer", "idle", episodes=3, seed=5, ticks=20, workers=2)
    assert [result.match.seed for result in results] == [5, 6, 7]


def test_members_of_a_group_play_in_turn() -> None:
    results = play("people:A", "people:A", episodes=2, ticks=3, workers=1)
    seats = [result.match.seats for result in results]
    assert seats == [("person:name=A01", "person:name=A02"), ("person:name=A02", "person:name=A03")]
