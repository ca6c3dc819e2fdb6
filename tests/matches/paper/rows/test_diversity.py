"""Populations are compared by equally many episodes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.training.recombined_paths import PIECES
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell
from movingout.matches.paper.entry import measurements
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES, RECOMBINED
from movingout.matches.paper.rows import measurements as measurements_of_agents
from movingout.matches.paper.rows.diversity import (
    diversity_over_maps,
    equal_cell,
    equal_sizes,
    learned_parts,
)
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.diversity.augmented import PATHS
from movingout.recordings.groups import grouped, write_groups
from tests.agents.learning import recorded, walked


def test_each_population_has_as_many_episodes_as_the_smallest_on_that_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    for data, count in (("c1", 6), ("c2", 3)):
        files = [recorded(tmp_path / data, f"{data}{k}", 20, k, (f"a{k}", f"b{k}")) for k in range(count)]
        write_groups(space.listing(data), grouped(files, 1))
    assert equal_sizes(space) == {"HandOff": 3}
    for data in ("c1", "c2"):
        measured = equal_cell(data, "entropy").measurement.perform(space, 0)
        assert measured["entropy"].n == 3, data


def test_single_episodes_have_no_diversity_and_the_table_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    for data in ("c1", "c2"):
        write_groups(space.listing(data), grouped([recorded(tmp_path / data, data, 20)], 1))
    one = equal_cell("c1", "entropy").measurement
    space.keep(one.name, one.perform(space, 0))
    table = laid_out(ENTRIES["table:task_1_diversity"], space)
    assert [row[1] for row in table.rows] == ["no value", "not measured", "not measured"]
    assert "has fewer than three episodes is left out" in " ".join(table.notes)
    needed = "Diversity needs 3 episodes of a map, and leaves out others"
    assert f"{needed}; 0 of 1 map have as many of each population." in table.notes


@pytest.mark.parametrize("label", ["text:augmentation", "tab:w1_recombination"])
def test_where_nothing_can_be_recombined_the_table_has_no_value_and_says_why(
    label: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    assert not any("episodes of a map" in note for note in laid_out(ENTRIES[label], space).notes)
    files = [recorded(tmp_path / "c1", f"c1{k}", 20, k, (f"a{k}", f"b{k}")) for k in range(3)]
    write_groups(space.listing("c1"), grouped(files[:1], 1))
    for one in measurements([ENTRIES[label]]):
        space.keep(one.name, one.perform(space, 0))
    table = laid_out(ENTRIES[label], space)
    assert {row[1] for row in table.rows} <= {"no value", "–"}  # of valid, or, of recorded ones, of nothing
    assert "No value: no map has three, or, of valid" in " ".join(table.notes)
    said = "Diversity needs 3 episodes of a map, and leaves out others; 0 of 1 map have as many recorded."
    assert said in table.notes
    write_groups(space.listing("c1"), grouped(files, 1))
    assert not any("episodes of a map" in note for note in laid_out(ENTRIES[label], space).notes)


@pytest.mark.parametrize(
    ("label", "said"),
    [
        ("table:task_1_diversity", "0 of 1 map have as many of each population."),
        ("text:augmentation", "0 of 1 map have as many recorded."),
        ("tab:w1_recombination", "0 of 1 map have as many recorded."),
        ("tab:pose_noise_ablation", "rests on 1 episode of HandOff."),
    ],
)
def test_tables_are_laid_out_where_the_episodes_are_no_longer_there(
    label: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(measurements_of_agents, "NOISE_MAP", "HandOff")
    space = Workspace(budget=BUDGETS["smoke"])
    for data in ("c1", "c2"):
        file = recorded(tmp_path / data, data, 20)
        write_groups(space.listing(data), grouped([file], 1))
        file.unlink()
    assert any(said in note for note in laid_out(ENTRIES[label], space).notes)


def test_a_map_with_two_episodes_has_no_variance_and_takes_no_error_away() -> None:
    random = np.random.default_rng(1)
    paths = [("one", random.uniform(-1, 1, (20, 4))) for _ in range(6)]
    alone = diversity_over_maps(paths)
    assert alone["dtw_variance"].mean > 0.0 and alone["dtw_variance"].stderr is not None
    assert diversity_over_maps([*paths, *(("two", path) for _, path in paths[:2])]) == alone
    assert diversity_over_maps(paths[:2]) == {}


@pytest.mark.parametrize(
    ("label", "of_matches"),
    [("table:task_1_diversity", False), ("text:augmentation", True), ("tab:w1_recombination", True)],
)
def test_tables_of_diversity_say_what_their_errors_are(
    label: str, of_matches: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    notes = laid_out(ENTRIES[label], Workspace(budget=BUDGETS["smoke"])).notes
    assert "Of diversity, ± is the jackknife's standard error over distinct paths" in notes[-1]
    assert ("± is the standard error over matches or samples; n counts them." in notes) == of_matches


@pytest.mark.parametrize("label", ["text:augmentation", "tab:w1_recombination"])
def test_tables_of_recombination_say_which_paths_they_compare(label: str) -> None:
    assert PIECES == 4 and f"up to four times as many recombined ones (of all of them {PATHS} per map)" in RECOMBINED
    assert RECOMBINED in ENTRIES[label].notes and "go on in the other episode to its end" in ENTRIES[label].differs


def test_the_table_of_diversity_is_of_equally_many() -> None:
    names = {cell.ours.measurement.name for cell in ENTRIES["table:task_1_diversity"].cells()
             if isinstance(cell.ours, MeasuredCell)}  # fmt: skip
    assert names == {"diversity-of-equal-c1", "diversity-of-equal-c2", "diversity-of-equal-mappo"}


def test_recombined_are_the_seats_that_agents_learn_from() -> None:
    both, agent = walked(ticks=20), replace(walked(ticks=20), kinds=("agent", "human"))
    idle = replace(walked(ticks=20), kinds=("agent", "idle"))
    scripted, given = (Workspace(budget=BUDGETS["smoke"], given=given) for given in ((), (Path("theirs"),)))
    assert [part.seat for part in learned_parts([both, idle], scripted)] == [0, 1, 0]
    assert [(part.trajectory, part.seat) for part in learned_parts([both, agent], given)] == [(agent, 1)]
