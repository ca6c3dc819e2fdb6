"""`study check` warns of agents that learned from what a study presents as new to them, or never saw its maps."""

import json
from pathlib import Path
from typing import Any

import pytest

from movingout.agents.checkpoint.checkpoint import CARD, MODELS_VARIABLE, SHIPPED
from movingout.maps import load_map
from movingout.maps.randomize import SPLITS, pairs_on, randomize, variant_pairs
from movingout.study.design.partner_origin import origin_warnings
from movingout.study.design.study_file import parse_study

STUDY = """\
format: 1
id: pilot
title: A pilot
participants: 2
consent: {{version: "1", text: We record how you play.}}
partners:
  - {{id: one, agent: "{agent}"}}
  - {{id: two, agent: scripted}}
blocks:
  - {{id: play, partners: [one, two], maps: [HandOff, FourCorners]{options}}}
debrief: {{text: They were programs.}}
"""
VARIED = ", challenge: 2"


def _warnings(agent: str, options: str = "") -> list[str]:
    return list(origin_warnings(parse_study(STUDY.format(agent=agent, options=options))))


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(MODELS_VARIABLE, str(tmp_path))
    return tmp_path


def _trained(models: Path, name: str, items: list[str] | None, **changes: Any) -> str:
    card = json.loads((SHIPPED / "dp-all" / CARD).read_text(encoding="utf-8"))
    card |= {"id": f"dp@{name}", "training": card["training"] | {"items": items}, **changes}
    (models / f"dp-{name}").mkdir()
    (models / f"dp-{name}" / CARD).write_text(json.dumps(card), encoding="utf-8")
    return f"dp@{name}"


def test_items_that_are_held_out_and_were_learned_from_are_named(models: Path) -> None:
    agent = _trained(models, "mine", ["large star", "small square", "small star"])
    (warning,) = _warnings(agent, VARIED)
    assert warning.startswith("block play: dp@mine learned from items that its variants hold out: ")
    assert "small square" in warning and "small star" not in warning
    assert _warnings(agent) == [], "nothing is held out on the maps as designed"
    assert _warnings(agent, f"{VARIED}, split: train") == []
    assert _warnings(_trained(models, "fair", ["small star"]), VARIED) == []


def test_a_card_that_does_not_say_what_was_learned_from_is_warned_of(models: Path) -> None:
    (warning,) = _warnings("dp@all", VARIED)
    assert "hold items out that dp@all may have learned from: the card does not say" in warning
    (warning,) = _warnings(_trained(models, "part", ["small star"], dynamics_training={
        "preset": "fast", "data_sha256": "0" * 64, "population": "", "episodes": 1, "windows": 1, "updates": 1,
        "seed": 0, "created": "2026-11-25",
    }), VARIED)  # fmt: skip
    assert "dp@part may have learned from" in warning


def test_maps_that_an_agent_has_never_seen_are_named_once(models: Path) -> None:
    agent = _trained(models, "few", [], maps=["LeftRight"])
    assert _warnings(f"{agent}:execute=1") == [
        "block play: dp@few:execute=1 has never seen the maps HandOff, FourCorners: it was trained on LeftRight"
    ]
    assert _warnings("scripted", VARIED) == _warnings("dp@nowhere", VARIED) == []


@pytest.mark.parametrize("name", ["HandOff", "PriorityPick", "AdaptiveAssist"])
def test_variants_have_the_pairs_that_are_said(name: str) -> None:
    spec = load_map(name)
    for split in SPLITS:
        seen = {pair for seed in range(3) for pair in pairs_on(randomize(spec, seed, split))}
        assert seen <= variant_pairs(spec, split)
