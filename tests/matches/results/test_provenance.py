"""Results that were played with another map file or other code of one's own are not taken for those of today."""

import hashlib
import importlib
import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.checkpoint.checkpoint import SHIPPED
from movingout.agents.own_code import code_fingerprint, source_sha256
from movingout.maps import load_map, map_to_json
from movingout.matches import MatchError, open_run, play, run_grid
from movingout.matches.results.provenance import provenance_of
from movingout.matches.results.results_folder import open_folder
from movingout.world.own_metrics import OwnMetric
from tests.matches.support import small_grid

pytestmark = pytest.mark.slow

AGENT = """
import numpy as np

class Driver:
    def reset(self, episode): pass
    def act(self, observation): return np.array([[{distance}, 1.0, 0.0, 0.0]])
"""


def _map_file(path: Path, robot_x: float) -> str:
    document = map_to_json(load_map("HandOff")) | {"name": "Own", "number": 0}
    document["robots"]["blue"]["x"] = robot_x
    path.write_text(json.dumps(document))
    return str(path)


def test_results_on_an_earlier_version_of_a_map_file_are_not_added_to(tmp_path: Path) -> None:
    name = _map_file(tmp_path / "own.json", 0.02)
    grid = small_grid(agents=["idle"], maps=[name, f"{name}:mirror"], seeds=1, ticks=2)
    run_grid(grid, tmp_path / "out", workers=1)
    (tmp_path / "own.json").write_text(json.dumps(json.loads((tmp_path / "own.json").read_text()), indent=3))
    run_grid(grid, tmp_path / "out", workers=1)  # written otherwise, but the same map
    _map_file(tmp_path / "own.json", 0.05)
    with pytest.raises(MatchError, match=r"started with another version of the map \S*own.json, \S*own.json:mirror;"):
        run_grid(grid, tmp_path / "out", workers=1)


def test_results_are_read_where_the_map_file_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _map_file(Path("own.json"), 0.02)
    grid = small_grid(agents=["idle"], maps=["own.json", "own.json:mirror"], seeds=1, ticks=2)
    played = run_grid(grid, tmp_path / "out", workers=1)
    Path("own.json").unlink()
    again = open_run(tmp_path / "out")
    assert again.results == played.results and again.plan == played.plan
    Path("grid.yaml").write_text("{name: again, agents: [idle], maps: [own.json]}")
    with pytest.raises(MatchError, match=r"cannot read the map file own\.json"):
        run_grid("grid.yaml", tmp_path / "out", workers=1)


@pytest.mark.parametrize("agent_id", ["own_driver:Driver", "late:agent=own_driver:Driver,delay=1"])
def test_results_of_earlier_code_are_not_added_to(
    agent_id: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own_driver.py").write_text(AGENT.format(distance=1.0))
    monkeypatch.syspath_prepend(tmp_path)
    grid = small_grid(agents=[agent_id], partners=["idle"], maps=["HandOff"], seeds=1, ticks=2)
    run_grid(grid, tmp_path / "out", workers=1)
    (tmp_path / "own_driver.py").write_text(AGENT.format(distance=-1.0))
    with pytest.raises(MatchError, match=r"started with other code of .*own_driver:Driver"):
        run_grid(grid, tmp_path / "out", workers=1)
    del sys.modules["own_driver"]


METRIC = """
from functools import partial

def value(scale, the_map, states, actions): return scale * float(len(actions))

class Computer:
    def __call__(self, *played): return value({scale}, *played)

COMPUTES = [lambda *played: value({scale}, *played), partial(value, {scale}), Computer(), Computer().__call__]
"""


def test_a_function_in_a_decorators_object_is_known_by_its_own_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file of the decorator counted: edits of the function were not noticed."""
    (tmp_path / "own_decorator.py").write_text(
        "import functools\n"
        "class Decorated:\n"
        "    def __init__(self, inner): functools.update_wrapper(self, inner)\n"
        "    def __call__(self): return self.__wrapped__()\n"
    )
    text = (
        "import functools, own_decorator\n@own_decorator.Decorated\ndef made(): pass\nPART = functools.partial(made)\n"
    )
    (tmp_path / "own_decorated.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module("own_decorated")
    own = hashlib.sha256(text.encode()).hexdigest()
    assert [source_sha256(module.made), source_sha256(module.PART)] == [own, own]
    assert code_fingerprint("own_decorated:made") == own


@pytest.mark.parametrize("compute", range(4), ids=["function", "partial", "object", "method"])
def test_results_of_earlier_code_of_a_metric_are_not_added_to(
    compute: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tables had the mean of metres and millimetres."""
    source = tmp_path / f"own_computes_{compute}.py"
    source.write_text(METRIC.format(scale=1))
    monkeypatch.syspath_prepend(tmp_path)
    computes = importlib.import_module(source.stem).COMPUTES
    metric = OwnMetric(
        key="length", symbol="L", title="Length", meaning="length", unit="", low=0.0, high=None,
        higher_is_better=False, digits=0, compute=computes[compute],
    )  # fmt: skip
    monkeypatch.setattr("movingout.matches.results.provenance.own_metrics", lambda: (metric,))
    grid = small_grid(maps=["HandOff"], seeds=1, ticks=2)
    open_folder(tmp_path / "out", grid, provenance_of(grid))
    open_folder(tmp_path / "out", grid, provenance_of(grid))
    source.write_text(METRIC.format(scale=1000))
    with pytest.raises(MatchError, match="started with other code of the metric length; choose another folder"):
        open_folder(tmp_path / "out", grid, provenance_of(grid))


def test_a_folder_learns_the_code_of_metrics_that_came_later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any code of them was accepted for ever, as in folders of versions that wrote none down."""
    grid, out = small_grid(agents=["idle"], maps=["HandOff"], seeds=1, ticks=2), tmp_path / "out"
    provenance = provenance_of(grid)
    later = replace(provenance, metrics={"length": "a"})
    open_folder(out, grid, provenance)
    open_folder(out, grid, replace(provenance, metrics={"length": "b"}))  # no value is of that code
    monkeypatch.setattr("movingout.matches.grid_run.provenance_of", lambda grid: later)
    run_grid(grid, out, workers=1)
    open_folder(out, grid, later)
    with pytest.raises(MatchError, match="started with other code of the metric length; choose another folder"):
        open_folder(out, grid, replace(provenance, metrics={"length": "b"}))


WEIGHTED = """
import numpy as np

class Weighted:
    def __init__(self, path): pass
    def reset(self, episode): pass
    def act(self, observation): return np.array([[0.0, 1.0, 0.0, 0.0]])
"""


@pytest.mark.parametrize("agent_id", ["weighted:Weighted:path={}", "late:agent=weighted:Weighted:path={},delay=1"])
def test_results_of_earlier_weights_that_an_option_names_are_not_added_to(
    agent_id: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A grid mixed the results of two sets of weights, since only the code of an own agent counted."""
    (tmp_path / "weighted.py").write_text(WEIGHTED)
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "policy.pkl"
    file.write_bytes(b"old")
    grid = small_grid(agents=[agent_id.format(file)], partners=["idle"], maps=["HandOff"], seeds=1, ticks=2)
    run_grid(grid, tmp_path / "out", workers=1)
    run_grid(grid, tmp_path / "out", workers=1)
    file.write_bytes(b"trained again")
    with pytest.raises(MatchError, match=r"started with other weights of .*weighted:Weighted:path=\S*policy.pkl"):
        run_grid(grid, tmp_path / "out", workers=1)
    del sys.modules["weighted"]


def test_results_with_an_earlier_recording_of_a_ghost_are_not_added_to(tmp_path: Path) -> None:
    [one, other] = [Path(result.recording) for result in play(
        "idle", "greedy", "HandOff", episodes=2, ticks=3, workers=1, record=tmp_path / "played"
    )]  # fmt: skip
    file = tmp_path / "seat.mcap"
    shutil.copy(one, file)
    grid = small_grid(agents=["idle"], partners=[f"ghost:{file}#red"], maps=["HandOff"], seeds=1, ticks=2)
    run_grid(grid, tmp_path / "out", workers=1)
    run_grid(grid, tmp_path / "out", workers=1)
    shutil.copy(other, file)
    with pytest.raises(MatchError, match=r"started with other weights of ghost:\S*seat.mcap#red"):
        run_grid(grid, tmp_path / "out", workers=1)


@pytest.mark.parametrize("agent_id", ["clone:seed=3", "clone", "late:agent=clone:seed=3;jitter=0.1,delay=2"])
def test_the_usual_agent_inside_another_counts_and_so_does_the_innermost(agent_id: str) -> None:
    """Only agents inside that were named counted, and only one level of them."""
    grid = small_grid(agents=["idle"], partners=[agent_id], maps=["HandOff"], seeds=1)
    assert list(provenance_of(grid).checkpoints) == ["dp@all"]


def test_results_with_other_members_of_a_family_are_not_added_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A trained agent that came later made a finished folder incomplete, and the next run changed its pairs."""
    grid = small_grid(agents=["idle"], partners=["family:clone", "families"], maps=["Simple"], seeds=1, ticks=2)
    document = provenance_of(grid)
    assert set(document.groups) == {"family:clone", "families"} and document.lists == {}
    open_folder(tmp_path, grid, document)
    missing = open_run(tmp_path).missing
    shutil.copytree(SHIPPED, tmp_path / "models", ignore=lambda _, names: {"gru-all"} & set(names))
    monkeypatch.setattr("movingout.agents.checkpoint.checkpoint.SHIPPED", tmp_path / "models")
    with pytest.raises(MatchError, match="started with other members of families, family:clone; choose another folder"):
        open_folder(tmp_path, grid, provenance_of(grid))
    with pytest.raises(MatchError, match="played with other members of families, family:clone; the trained agents of"):
        open_run(tmp_path)
    head = json.loads((tmp_path / "grid.json").read_text())
    del head["groups"]  # as an earlier version wrote it
    (tmp_path / "grid.json").write_text(json.dumps(head))
    assert open_run(tmp_path).missing == missing
    open_folder(tmp_path, grid, provenance_of(grid))


@pytest.mark.parametrize("where", ["partners", "maps"])
def test_results_with_an_earlier_version_of_a_list_are_not_added_to(where: str, tmp_path: Path) -> None:
    said, more = {"partners": ("idle", "greedy"), "maps": ("Simple", "HandOff")}[where]
    file = tmp_path / "list.txt"
    file.write_text(said)
    grid = small_grid(**{"agents": ["idle"], "maps": ["Simple"], "seeds": 1, "ticks": 2, where: [f"@{file}"]})
    run_grid(grid, tmp_path / "out", workers=1)
    file.write_text(f"# the same\n{said}\n")
    run_grid(grid, tmp_path / "out", workers=1)
    file.write_text(f"{said}\n{more}\n")
    with pytest.raises(MatchError, match=r"started with another version of the list @\S*list.txt;"):
        run_grid(grid, tmp_path / "out", workers=1)
    with pytest.raises(
        MatchError, match=r"was played with another version of the list @\S*list.txt; put that one back"
    ):
        open_run(tmp_path / "out")
    file.unlink()
    with pytest.raises(MatchError, match=r"list.txt"):
        open_run(tmp_path / "out")
    file.write_text(said)
    assert len(open_run(tmp_path / "out").results) == 1


def test_everybody_on_a_list_must_be_there_before_a_grid_is_played(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("idle\ngready\n")
    grid = small_grid(agents=["idle"], partners=[f"@{tmp_path / 'list.txt'}"], maps=["Simple"], seeds=1, ticks=2)
    with pytest.raises(MatchError, match="needs agents that are not here: gready: unknown agent"):
        run_grid(grid, tmp_path / "out", workers=1)


def test_a_folder_of_before_there_were_hashes_of_code_and_maps_goes_on(tmp_path: Path) -> None:
    grid = small_grid(agents=["idle"], maps=[_map_file(tmp_path / "own.json", 0.02)], seeds=1, ticks=2)
    run_grid(grid, tmp_path / "out", workers=1)
    head = json.loads((tmp_path / "out/grid.json").read_text())
    (tmp_path / "out/grid.json").write_text(json.dumps({k: v for k, v in head.items() if k not in ("code", "maps")}))
    assert run_grid(grid, tmp_path / "out", workers=1).missing == 0


def test_weights_inside_another_agent_count_and_what_comes_with_the_project_has_no_hash_of_code() -> None:
    grid = small_grid(agents=["clone:policy=dp@all,delay=1"], partners=["scripted"], maps="all", seeds=1)
    provenance = provenance_of(grid)
    assert list(provenance.checkpoints) == ["dp@all"]
    assert provenance.code == provenance.maps == {}


def test_a_map_file_that_was_changed_is_played_as_it_is_now(tmp_path: Path) -> None:
    class Still:
        def reset(self, episode: EpisodeInfo) -> None:
            starts.append(episode.map.robots[0].x)

        def act(self, observation: Observation) -> ActionChunk:
            return np.array([[0.0, 1.0, 0.0, 0.0]])

    starts: list[float] = []
    for x in (0.02, 0.05):
        play(Still, "idle", _map_file(tmp_path / "own.json", x), ticks=1)
    assert starts == [0.02, 0.05]


class AnswersToEverything:
    """As a handle of a remote object: each name is there, `__wrapped__` too."""

    def __getattr__(self, name: str) -> "AnswersToEverything":
        return AnswersToEverything()

    def __call__(self, *_: object) -> float:
        return 0.0


def test_an_object_that_answers_to_every_name_has_the_hash_of_its_class() -> None:
    assert source_sha256(AnswersToEverything()) == source_sha256(AnswersToEverything)
