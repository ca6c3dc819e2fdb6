"""What is measured besides matches."""

from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.methods import NOISE_MAP
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows import measurements
from movingout.matches.paper.rows.measurements import noise_validity
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from movingout.world.estimates import Estimate
from tests.agents.learning import recorded


def test_states_of_an_episode_are_no_more_than_one_in_the_error_of_validity(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    files = [recorded(tmp_path / "c1", f"c1{k}", 20, k, (f"a{k}", f"b{k}")) for k in range(2)]
    write_groups(space.listing("c1"), grouped(files, 1))
    monkeypatch.setattr(measurements, "NOISE_MAP", "HandOff")
    drawn = [("0", 1.0)] * 50 + [("1", 0.0)] * 50
    monkeypatch.setattr(measurements, "valid_after_noise", lambda trajectories, *rest: drawn)
    found = noise_validity("0.02").measurement.perform(space, 0)["valid_share"]
    assert found == Estimate(0.5, 0.5, 100)


def test_the_table_says_on_how_many_episodes_the_error_of_validity_rests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space, entry = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,)), ENTRIES["tab:pose_noise_ablation"]
    assert not any("rests on" in note for note in laid_out(entry, space).notes)
    files = [
        recorded(tmp_path, f"{name}{number}", 9, the_map=load_map(name))
        for name, count in ((NOISE_MAP, 4), ("HandOff", 1))
        for number in range(count)
    ]
    write_groups(space.listing("c1"), grouped(files, 1))
    assert "Here ± of valid rests on 4 episodes of SingleRotation." in laid_out(entry, space).notes
