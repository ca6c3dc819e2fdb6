"""`movingout train response`: from a policy to its steering, with the commands a user types."""

import json
from pathlib import Path

import pytest

pytest.importorskip("torchrl")

from movingout.agents.catalogue import unseen_map
from movingout.agents.checkpoint.card import Training
from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies.export import save_policy
from movingout.maps import load_map, map_to_json
from movingout.maps.randomize import pair_text, pairs_on
from movingout.server.cli import main
from tests.agents.learning import tiny_spec

TINY = ["--updates", "1", "--rooms", "1", "--decisions", "2", "--batch", "2", "--passes", "1", "--ticks", "5"]
COMMAND = ["train", "response", "--base", "dp@base", "--id", "dp@answer", *TINY]


def save_base(folder: Path, agent_id: str = "dp@base", population: str = "A") -> None:
    """A policy that learned nothing."""
    training = Training(
        preset="fast", data_sha256="0" * 64, population=population, episodes=1, windows=2, updates=3, seed=4,
        created="2026-11-21", items=(),
    )  # fmt: skip
    policy = build_policy(tiny_spec(layout="relative-v1", obs_horizon=1, denoiser="items"))
    save_policy(folder / agent_id.replace("@", "-"), agent_id, policy, ["HandOff"], training, "DP", "Untrained.")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a policy to steer and a map of one's own."""
    monkeypatch.chdir(tmp_path)
    save_base(tmp_path / "data" / "models")
    own = map_to_json(load_map("HandOff")) | {"name": "Garage", "title": "The Garage", "number": 0}
    (tmp_path / "own.json").write_text(json.dumps(own))
    return tmp_path


def test_the_card_names_a_map_of_ones_own_by_its_name(here: Path) -> None:
    assert main([*COMMAND, "--partners", "idle", "--map", str(here / "own.json")]) == 0
    card = find_checkpoint("dp@answer", here / "data" / "models").card
    assert card.maps == ("Garage", "HandOff")
    assert card.learned_items == frozenset(map(pair_text, pairs_on(load_map("HandOff"))))
    assert not unseen_map("dp@answer", "Garage")


def test_the_card_shortens_a_long_list_of_partners(here: Path) -> None:
    save_base(here / "data" / "models", population="p" * 400)
    partners = [f"greedy:seed={number},order=near,patience=40" for number in range(12)]
    assert main([*COMMAND, "--map", "HandOff", "--partners", *partners]) == 0
    card = find_checkpoint("dp@answer", here / "data" / "models").card
    assert "…; then a best response to greedy:seed=0" in card.training.population
    assert card.training.population.endswith("…") and card.description.endswith("…")


def test_another_base_or_another_list_of_partners_is_no_silent_continuation(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_base(here / "data" / "models", "dp@other")
    (here / "list.txt").write_text("idle\n")
    command = [*COMMAND, "--map", "HandOff", "--partners", "@list.txt"]
    assert main(command) == 0
    assert main([*command, "--base", "dp@other", "--go-on"]) == 2
    assert (
        "base dp@base, not dp@other; to continue it, add --base dp@base, or train that under" in capsys.readouterr().err
    )
    (here / "list.txt").write_text("greedy:seed=1\n")
    assert main(command) == 2
    assert "this run was started with data of SHA-256" in capsys.readouterr().err
    assert main([*command, "--go-on"]) == 2
    assert "dp@answer has made all of its 1 updates; to train on, give a larger --updates" in capsys.readouterr().err
    assert main([*command, "--map", "Simple", "--go-on", "--updates", "2"]) == 0
    card = find_checkpoint("dp@answer", here / "data" / "models").card
    both = frozenset(pair_text(pair) for name in ("HandOff", "Simple") for pair in pairs_on(load_map(name)))
    assert (card.maps, card.learned_items) == (("HandOff", "Simple"), both)
    assert card.description == "DP, steered by reinforcement learning beside @list.txt on 1 map, and on others before."


def test_a_map_that_a_partner_does_not_see_is_refused_before_anything_is_played(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    five = map_to_json(load_map("Simple")) | {"name": "Five", "goals": goals}
    (here / "five.json").write_text(json.dumps(five))
    assert main([*COMMAND, "--map", "five.json", "--partners", "idle"]) == 2
    assert "the layout relative-v1 has 4 slots for goals; Five has 5" in capsys.readouterr().err
    walls = [{"x0": x / 10, "y0": 1.2, "x1": x / 10 + 0.05, "y1": 1.15} for x in range(-9, 0)]
    nine = map_to_json(load_map("Simple")) | {"name": "Nine", "walls": walls}
    (here / "nine.json").write_text(json.dumps(nine))
    assert main([*COMMAND, "--map", "nine.json", "--partners", "idle", "dp@all"]) == 2
    assert "dp@all cannot play Nine: the layout aware-v1 has 8 slots for walls; Nine has 9" in capsys.readouterr().err
    assert not (here / "data" / "runs").exists()
