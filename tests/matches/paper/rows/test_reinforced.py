"""Agents that learned by reinforcement in the paper's tables: one per map, from no episodes, and how they behave."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from movingout.maps import map_names
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell, Measurement, PlayedCell, PooledCell
from movingout.matches.paper.costs import training_seconds
from movingout.matches.paper.entry import PaperEntry, played_cells
from movingout.matches.paper.methods import METHODS, trained_id
from movingout.matches.paper.presentation.bar_chart import bar_chart
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows import reinforced
from movingout.matches.paper.rows.reinforced import behaviour, reinforced_seen, reinforced_unseen, zero_shot
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.training import training_words as _words
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate

TCR = PublishedColumn(1, "tcr")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def test_every_map_has_agents_of_its_own_with_two_seeds(here: Path) -> None:
    space = Workspace(budget=BUDGETS["small"])
    seen, unseen = reinforced_seen(TCR), reinforced_unseen(TCR)
    assert isinstance(seen, PooledCell) and isinstance(unseen, PooledCell)
    matches = [match for part in seen.parts for match in part.matches(space)]
    assert [(one.map, *one.seats) for one in matches[:3]] == [
        ("HandOff", "mappo-1@a", "mappo-1@a"), ("HandOff", "mappo-1@b", "mappo-1@b"),
        ("PassOrSplit", "mappo-2@a", "mappo-2@a"),
    ]  # fmt: skip
    assert len(matches) == 24 and {one.map for one in matches} == set(map_names())
    assert [one.seats for one in unseen.parts[11].matches(space)] == [
        ("mappo-12@a", "mappo-12@b"), ("mappo-12@b", "mappo-12@a"),
    ]  # fmt: skip
    assert seen.found(space) is None and len(seen.agents) == 24


def test_the_second_challenge_has_a_row_of_ours_without_a_number_of_the_papers(here: Path) -> None:
    entry = ENTRIES["fig:results_t2"]
    cells = [cell for cell in entry.cells() if cell.row.name == "MAPPO"]
    assert {cell.column.measure for cell in cells} == {"tcr", "nfd", "waiting_share", "ac", "official_ac"}
    assert all(cell.theirs is None for cell in cells)
    assert entry.state == "in part" and "people in Challenge 2" in entry.lacks, "the paper's figure has bars of people"
    (first, *_), space = (cell.ours for cell in cells), Workspace(budget=BUDGETS["small"])
    assert isinstance(first, PooledCell)
    matches = [match for part in first.parts for match in part.matches(space)]
    assert [(one.map, one.seats, one.challenge) for one in matches[:1]] == [("HandOff", ("mappo-1@c2",) * 2, 1)]
    assert len(matches) == 12 == len({one.map for one in matches})
    held_out = first.parts[0].matches(Workspace(budget=BUDGETS["small"], evaluation="held-out"))
    assert [one.challenge for one in held_out] == [2]
    picture = bar_chart(entry, space)
    assert picture.count(">MAPPO</text>") == 5 and picture.count('class="theirs"') == 20


def test_a_sparse_reward_stands_beside_the_dense_one(here: Path) -> None:
    space = Workspace(budget=BUDGETS["small"])
    cells = {(cell.row.name, cell.column.measure): cell.ours for cell in ENTRIES["text:sparse_reward"].cells()}
    dense, sparse = cells["Dense reward", "tcr_map_6"], cells["Sparse reward", "nfd_map_6"]
    assert isinstance(dense, PlayedCell) and isinstance(sparse, PlayedCell) and sparse.measure == "nfd"
    assert [one.seats[0] for one in dense.matches(space)] == ["mappo-6@a", "mappo-6@b"]
    assert [(one.map, one.seats) for one in sparse.matches(space)] == [
        ("DistancePriority", (f"mappo-6-sparse@{seed}",) * 2) for seed in "ab"
    ]
    assert METHODS["mappo-6-sparse"].options == ("--map", "DistancePriority", "--reward", "paper-sparse")
    assert {cell.agents for cell in cells.values()} == {
        ("mappo-6@a", "mappo-6@b"), ("mappo-6-sparse@a", "mappo-6-sparse@b"),
    }  # fmt: skip


def test_strangers_in_the_comparison_of_zero_shot_coordination_learned_from_people(here: Path) -> None:
    cell = zero_shot("comedi")(PublishedColumn(1, "tcr_map_12_unseen"))
    assert isinstance(cell, PlayedCell) and cell.maps == ("SequentialRotations",)
    assert cell.agents == ("comedi-12@a", "dp@b", "comedi-12@b")


def test_they_need_no_episodes(here: Path) -> None:
    entry = PaperEntry(
        label="tab:zsc_comparison", kind="table", otherwise="-",
        rows={("", "MAPPO"): lambda column: zero_shot("mappo")(column._replace(measure="tcr_map_1_seen"))},
    )  # fmt: skip
    assert [step.about for step in paper_steps([entry], Workspace(budget=BUDGETS["small"]))] == [
        "train mappo-1@a (mappo)", "train mappo-1@b (mappo)", "play 2 matches",
    ]  # fmt: skip
    assert {cell.agents for cell in played_cells([entry])} == {("mappo-1@a", "mappo-1@b")}


def test_they_are_trained_on_their_map_with_a_seed_of_their_own(here: Path) -> None:
    space = Workspace(budget=BUDGETS["small"])
    words = [str(word) for word in _words(trained_id("comedi-12@b-1"), space)]
    assert words[0] == "comedi" and "--population" not in words
    said = {name: words[words.index(name) + 1] for name in ("--map", "--frames", "--members", "--seed")}
    assert said == {"--map": "SequentialRotations", "--frames": "12000", "--members": "2", "--seed": "3"}
    full = training_seconds(METHODS["comedi-12"], BUDGETS["full"])
    assert full == 4 * training_seconds(METHODS["mappo-12"], BUDGETS["full"]) > 4 * 5 * 3600


def test_behaviour_is_counted_in_episodes() -> None:
    six = dict(reinforced._of_episode("scripted", 6, 0, 300))
    assert set(six) == {"map_6_middle_first", "map_6_first_grasp_s", "map_6_first_shared_s"}
    assert 0.0 < six["map_6_first_grasp_s"] <= six["map_6_first_shared_s"] <= 30.0
    assert 0.0 <= six["map_6_middle_first"] <= 1.0
    assert dict(reinforced._of_episode("idle", 6, 0, 20)) == {}


def test_what_never_happened_has_no_value(here: Path) -> None:
    space = Workspace(budget=BUDGETS["small"])
    cell = behaviour("mappo-{}")(PublishedColumn(1, "map_11_first_shared_s"))
    assert isinstance(cell, MeasuredCell) and cell.agents == ("mappo-11@a", "mappo-11@b")
    assert cell.found(space) is None
    space.keep(cell.measurement.name, {"map_11_first_grasp_s": Estimate(3.0, 0.1, 8)}, cell.agents, 4)
    found = cell.found(space)
    assert found is not None and found.estimate is None
    assert MeasuredCell(Measurement("other", "", lambda space, training: {}), "x").found(space) is None


def test_the_appendix_is_laid_out_with_what_it_needs(here: Path) -> None:
    steps = [step.about for step in paper_steps([ENTRIES["appx:comparsion_BC_RL"]], Workspace(budget=BUDGETS["smoke"]))]
    assert [about for about in steps if about.startswith("train")] == [
        "train mappo-6@a (mappo)", "train mappo-6@b (mappo)", "train mappo-11@a (mappo)", "train mappo-11@b (mappo)",
        "train dp@a (dp)", "train dp@b (dp)",
    ]  # fmt: skip
    assert "measure how dp behaves on FourCorners" in steps
