"""Figures that are painted show what the paper's show."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest
from PIL import Image

from movingout.maps import MapSpec, load_map
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation import pictures
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from movingout.world.state import Floats
from tests.agents.learning import recorded


def test_positions_are_of_four_pairs_and_of_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    people = [("a", "b"), ("b", "a"), ("c", "d"), ("e", "f"), ("g", "h"), ("i", "j")]  # the first two are one pair
    files = [
        recorded(tmp_path, f"{name}-{number}", 9, people=pair, the_map=load_map(name))
        for name in ("HandOff", "LeftRight")
        for number, pair in enumerate(people)
    ]
    write_groups(space.listing("c1"), grouped(files, 2))
    shown: list[tuple[str, dict[str, int]]] = []

    def plot(spec: MapSpec, groups: Mapping[str, Sequence[Floats]], style: str) -> Image.Image:
        shown.append((spec.name, {name: len(paths) for name, paths in groups.items()}))
        return Image.new("RGB", (8, 4))

    monkeypatch.setattr(pictures, "position_plot", plot)
    assert pictures.positions(space).size == (8, 8)
    counts = {"pair 1": 2, "pair 2": 1, "pair 3": 1, "pair 4": 1, "all": 6}
    assert sorted(shown) == [("HandOff", counts), ("LeftRight", counts)], "as in the paper"
