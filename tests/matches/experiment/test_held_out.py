"""A grid warns of agents that learned from the items which its variants hold out."""

import json
from pathlib import Path
from typing import Any

import pytest

from movingout.agents.checkpoint.checkpoint import CARD, MODELS_VARIABLE, SHIPPED
from movingout.matches import read_grid
from movingout.matches.experiment.held_out import held_out_cautions
from movingout.matches.experiment.shipped_grids import grid_path
from movingout.server.cli import main
from tests.matches.support import small_grid


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(MODELS_VARIABLE, str(tmp_path))
    return tmp_path


def _trained(models: Path, name: str, items: list[str]) -> str:
    card = json.loads((SHIPPED / "dp-all" / CARD).read_text(encoding="utf-8"))
    card |= {"id": f"dp@{name}", "training": card["training"] | {"items": items}}
    (models / f"dp-{name}").mkdir()
    (models / f"dp-{name}" / CARD).write_text(json.dumps(card), encoding="utf-8")
    return f"dp@{name}"


def _cautions(agent: str, **changes: Any) -> list[str]:
    return list(held_out_cautions(small_grid(agents=[agent, "scripted"], maps=["HandOff"], challenge=2, **changes)))


def test_items_that_are_held_out_and_were_learned_from_are_named(models: Path) -> None:
    agent = _trained(models, "mine", ["large star", "small square", "small star"])
    (caution,) = _cautions(f"{agent}:execute=1")
    assert caution.startswith("dp@mine:execute=1 learned from items that the variants of this grid hold out (")
    assert "small square" in caution and "small star" not in caution
    assert _cautions(f"late:agent={agent}"), "it decides, with late hands"
    assert _cautions(agent, split="train") == _cautions(_trained(models, "fair", ["small star"])) == []
    assert list(held_out_cautions(small_grid(agents=[agent], maps=["HandOff"]))) == [], "as designed"


def test_an_id_that_cannot_be_read_is_left_to_the_list_of_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It stopped a dry run before that list."""
    grid = tmp_path / "grid.yaml"
    grid.write_text("name: odd\nagents: ['late:agent=dp@all,zzz', dp@nowhere]\nmaps: [HandOff]\nchallenge: 2\n")
    assert main(["match", "grid", str(grid), "--dry-run", "--out", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "missing: dp@nowhere: " in out and "missing: late:agent=dp@all,zzz: " in out


def test_a_card_that_does_not_say_is_warned_of_where_a_split_is_asked_for() -> None:
    assert _cautions("dp@all") == [] == _cautions("dp@nowhere", split="evaluation")
    (caution,) = _cautions("dp@all", split="evaluation")
    assert "hold items out that dp@all may have learned from" in caution


def test_the_shipped_grid_of_unseen_combinations_warns_of_its_agents(models: Path) -> None:
    _trained(models, "c2", ["small triangle"])
    (caution,) = held_out_cautions(read_grid(grid_path(Path("challenge-2"))))
    assert caution.startswith("dp@c2 learned from items") and "(small triangle)" in caution
