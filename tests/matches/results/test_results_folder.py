"""A results folder goes on with the grid that it was begun with."""

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from movingout.matches.errors import MatchError
from movingout.matches.experiment.grid import Grid
from movingout.matches.results.provenance import Provenance
from movingout.matches.results.results_folder import open_folder, read_head
from tests.matches.support import small_grid

AGENTS: dict[str, Any] = {"agents": ["idle", {"agent": "dp@all", "needs": "make agents"}], "partners": ["idle"]}
CONDITIONS: dict[str, Any] = {"agents": None, "conditions": [{"name": "one", **AGENTS}]}


def other_hint(grid: Grid) -> Grid:
    return Grid.model_validate_json(grid.model_dump_json().replace("make agents", "movingout train dp"))


def begun_now(folder: Path, grid: Grid) -> None:
    open_folder(folder, grid, Provenance({}, {}, {}))


def begun_before(folder: Path, grid: Grid) -> None:
    """As earlier versions wrote it, whose fingerprint had the hints."""
    begun_now(folder, grid)
    head = json.loads((folder / "grid.json").read_text())
    played = {key: value for key, value in head["grid"].items() if key not in ("name", "about")}
    head["sha256"] = hashlib.sha256(json.dumps(played, sort_keys=True).encode()).hexdigest()
    (folder / "grid.json").write_text(json.dumps(head))


@pytest.mark.parametrize("agents", [AGENTS, CONDITIONS], ids=["agents", "conditions"])
@pytest.mark.parametrize("begin", [begun_before, begun_now])
def test_another_hint_how_to_get_an_agent_is_no_other_grid(agents: dict[str, Any], begin: Any, tmp_path: Path) -> None:
    """A shipped grid with better hints refused every folder that was begun before."""
    grid = small_grid(**agents)
    begin(tmp_path, grid)
    assert other_hint(grid) != grid
    open_folder(tmp_path, other_hint(grid), Provenance({}, {}, {}))
    with pytest.raises(MatchError, match="another grid"):
        open_folder(tmp_path, small_grid(**agents, seeds=4), Provenance({}, {}, {}))


def test_a_folder_whose_grid_cannot_be_played_here_is_of_another_grid(tmp_path: Path) -> None:
    open_folder(tmp_path, small_grid(), Provenance({}, {}, {}))
    head = json.loads((tmp_path / "grid.json").read_text())
    head |= {"sha256": "0" * 64, "grid": head["grid"] | {"maps": ["NoSuchMap"]}}
    (tmp_path / "grid.json").write_text(json.dumps(head))
    with pytest.raises(MatchError, match="another grid"):
        open_folder(tmp_path, small_grid(), Provenance({}, {}, {}))


def test_a_folder_of_a_format_of_before_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "grid.json").write_text('{"format": 1, "sha256": "", "grid": {}, "versions": {}}')
    with pytest.raises(MatchError, match=r"is not of format 2: .* play the grid again, into an empty folder"):
        read_head(tmp_path)
