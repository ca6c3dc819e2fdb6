"""How the presets of MAPPO differ, and that the page about learning says all of it."""

from typing import Any, get_args

import pytest

from movingout.agents.reinforcement.mappo_config import ON_COORDINATION, PAPER, ArenaLayout, MappoConfig
from movingout.world.observation import LAYOUTS
from tests.support import ROOT

FAST = MappoConfig()
SAID = {
    "frames": "{fast:,} frames instead of {paper:,}",
    "ticks": "episodes of {fast} ticks instead of {paper:,}",
    "rate": "a learning rate of {fast} instead of {paper:.5f}",
    "passes": "{fast} passes instead of {paper}",
    "normalise": "normalised advantages",
    "grasp": "a grasp that is a level instead of a press",
}


def page() -> str:
    """The words about `--preset fast`."""
    text = " ".join((ROOT / "docs/learning.md").read_text(encoding="utf-8").split())
    return text.partition("`--preset fast`, the default, has ")[2].partition(" - **CoMeDi**")[0]


def test_nothing_else_differs() -> None:
    assert {name for name, value in PAPER.items() if getattr(FAST, name) != value} == set(SAID)


@pytest.mark.parametrize("name", SAID)
def test_every_difference_is_said_with_its_numbers(name: str) -> None:
    numbers: dict[str, Any] = {"fast": getattr(FAST, name), "paper": PAPER[name]}
    assert SAID[name].format(**numbers) in page()


def test_what_the_paper_has_on_the_maps_of_coordination_is_said_to_be_missing() -> None:
    assert ON_COORDINATION.keys() == {"ticks", "entropy", "discount"}
    assert f"{FAST.ticks} ticks, entropy {FAST.entropy:g}, discount {FAST.discount}" in page()


def test_every_layout_of_numbers_with_headings_of_the_arena_can_be_learned_from_and_is_in_the_help() -> None:
    arena = [name for name, layout in LAYOUTS.items() if not layout.picture and not layout.own_frame]
    assert list(get_args(ArenaLayout)) == arena
    assert all(name in MappoConfig.__dataclass_fields__["layout"].metadata["help"] for name in arena)
