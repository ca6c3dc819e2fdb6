"""A grid warns of a label that mixes agents with the same partners."""

from pathlib import Path
from typing import Any

import pytest

from movingout.matches import read_grid
from movingout.matches.experiment.shared_labels import shared_label_cautions
from movingout.matches.experiment.shipped_grids import grid_path, shipped_grids
from movingout.server.cli import main
from tests.matches.support import small_grid


def _cautions(*agents: Any, **changes: Any) -> list[str]:
    return list(shared_label_cautions(small_grid(agents=list(agents), **changes)))


def test_agents_of_one_label_with_the_same_partner_are_named() -> None:
    """Tables had the mean of both, without a word."""
    idle, greedy = {"agent": "idle", "label": "mine"}, {"agent": "scripted", "label": "mine"}
    (caution,) = _cautions(idle, greedy, partners=["idle"], name="small")
    assert caution.startswith("mine stands for 2 agents with the same partners in small: idle, scripted; ")
    assert _cautions(idle, greedy), "each with each"
    assert _cautions({**idle, "partners": ["idle"]}, {**greedy, "partners": ["scripted"]}) == [], "pooled on purpose"
    assert _cautions({**idle, "partners": ["idle"]}, {**idle, "partners": ["scripted"]}) == [], "one agent"
    assert _cautions("idle", "scripted") == []


@pytest.mark.parametrize("name", shipped_grids())
def test_shipped_protocols_mix_nothing(name: str) -> None:
    assert list(shared_label_cautions(read_grid(grid_path(Path(name))))) == []


def test_the_command_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    grid = tmp_path / "grid.yaml"
    grid.write_text(
        "name: odd\nagents: [{agent: idle, label: mine}, {agent: scripted, label: mine}]\npartners: [idle]\n"
        "maps: [HandOff]\nseeds: 1\nticks: 5\n"
    )
    assert main(["match", "grid", str(grid), "--dry-run", "--out", str(tmp_path / "out")]) == 0
    assert "movingout: mine stands for 2 agents" in capsys.readouterr().err
