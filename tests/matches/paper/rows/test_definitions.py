"""The settings of MAPPO and of the reward stand beside the paper's, and are the same."""

from pathlib import Path

import pytest
from torch.nn import Linear

from movingout.agents.bass.dynamics import AutoEncoder
from movingout.agents.checkpoint.card import DynamicsSpec
from movingout.matches.paper import data_sets
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import DefinedCell
from movingout.matches.paper.presentation.layout import laid_out, plain
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows.definitions import LINEAR_LAYERS, NO_EPSILON, NO_TARGET, pose_shift
from movingout.matches.paper.rows.measurements import noise_samples
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from movingout.server.cli import main
from tests.agents.learning import recorded


@pytest.mark.parametrize(
    ("label", "rows", "different"),
    [
        ("mappo_parameters", 26 + 3, [NO_TARGET] * 3 + [NO_EPSILON] * 2), ("tab:dense_rewards", 10, []),
        ("text:policy_parameters", 33, ["3"]),
    ],
)  # fmt: skip
def test_settings_are_the_papers(label: str, rows: int, different: list[str]) -> None:
    """But for those that do nothing in MAPPO, which say so, and the layers of BASS."""
    cells = list(ENTRIES[label].cells())
    assert ENTRIES[label].state == "whole" and len(cells) == rows
    others = []
    for cell in cells:
        assert isinstance(cell.ours, DefinedCell) and cell.theirs is not None
        if not cell.theirs.says(cell.ours.value):
            others.append(str(cell.ours.value))
    assert others == different


def test_the_layers_of_bass_are_counted() -> None:
    network = AutoEncoder(DynamicsSpec(width=4, latent=2))
    for part in (network.encoder, network.decoder):
        assert sum(isinstance(layer, Linear) for layer in part) == LINEAR_LAYERS


def test_the_full_budget_has_the_papers_data_sets() -> None:
    """But that scripted people finish all maps."""
    cells = {(cell.row.group, cell.row.name): cell for cell in ENTRIES["text:data_sets"].cells()}
    others = [
        (name, cell.ours.value)
        for name, cell in cells.items()
        if isinstance(cell.ours, DefinedCell) and not (cell.theirs and cell.theirs.says(cell.ours.value))
    ]
    assert len(cells) == 6 and others == [(("Challenge 1", "Episodes"), 12 * 18 * 6)]


def test_sizes_of_given_recordings_are_theirs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space, entry = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,)), ENTRIES["text:data_sets"]
    assert [row[1] for row in laid_out(entry, space).rows] == ["not measured"] * 6
    files = [
        recorded(tmp_path, f"{number}", 9, people=(name, "bass@all"), kinds=("human", "agent"))
        for number, name in enumerate(("P1", "P1", "P2"))
    ]
    write_groups(space.listing("c1"), grouped(files, 2))
    table = laid_out(entry, space)
    assert [row[1] for row in table.rows] == ["2", "1.5", "3", *["not measured"] * 3]
    assert any("With --data they are counted in the recordings" in note for note in table.notes)
    nameless = recorded(tmp_path, "nameless", 9, people=("P1", ""), kinds=("human", "human"))
    write_groups(space.listing("c2"), grouped([nameless], 1))
    assert laid_out(entry, space).rows[3][1] == "1 participant and people without a name"
    write_groups(space.listing("c2"), grouped([recorded(tmp_path, "agents", 9, people=("dp@all", "dp@c1"))], 1))
    assert laid_out(entry, space).rows[3][1] == "2 agents"
    replays = [
        recorded(tmp_path, f"replay{name}", 9, people=(name, "bass@all"), kinds=("ghost", "agent")) for name in "12"
    ]
    write_groups(space.listing("c2"), grouped(replays, 1))
    assert laid_out(entry, space).rows[3][1] == "1 agent", "who is replayed is none"


def test_sizes_of_given_recordings_need_no_other_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(data_sets, "map_names", lambda: ("HandOff",))  # of the twelve
    for name in "abc":
        recorded(tmp_path / "live", name, 9, people=(name, f"{name}2"), kinds=("human", "human"))
    asked = ["paper", "tables", "text:data_sets", "--data", "live", "--budget", "smoke", "-o", "out"]
    assert main([*asked, "--dry-run"]) == 0 and "Challenge 1 to count them" in capsys.readouterr().out
    assert main(asked) == 0
    shown = capsys.readouterr()
    assert "| Challenge 1: Participants | 6 | 36 | – |" in shown.out
    assert "| Challenge 1: Episodes | 3 | 1,000 | – |" in shown.out
    assert "| Challenge 2: Episodes | not measured | 720 |" in shown.out
    assert "they are not counted: none of 3 recordings is on a varied map" in shown.err
    assert main(asked) == 0 and "episodes of Challenge 1 to" not in capsys.readouterr().err, "which are listed"


def test_settings_that_are_words_are_words_of_the_paper() -> None:
    cells = {cell.row.name: cell.theirs for cell in ENTRIES["mappo_parameters"].cells()}
    sizes, loss, rate = cells["Linear Layer Sizes"], cells["Critic Loss Type"], cells["Adam Epsilon"]
    assert sizes is not None and loss is not None and rate is not None
    assert sizes.says("[256, 256]") and not sizes.says("[256]") and not sizes.says(256)
    assert loss.says("l2") and not loss.is_number and rate.says(1e-6) and not rate.says("1e-6")


def test_shifts_are_about_the_papers() -> None:
    assert [pose_shift(deviation).value for deviation in (0.0002, 0.002, 0.02, 0.2)] == [0.00043, 0.0043, 0.043, 0.43]


def test_as_many_states_are_perturbed_as_in_the_paper() -> None:
    assert {name: noise_samples(budget) for name, budget in BUDGETS.items() if name != "smoke"} == dict.fromkeys(
        [name for name in BUDGETS if name != "smoke"], 2000
    )
    assert noise_samples(BUDGETS["smoke"]) == 100


def test_numbers_are_written_without_an_exponent() -> None:
    assert [plain(value) for value in (0.00005, 30_000_000, 5, 0.0, -0.01, 1000, 0.301)] == [
        "0.00005", "30,000,000", "5", "0", "-0.01", "1000", "0.301",
    ]  # fmt: skip


def test_a_table_of_settings_needs_no_training(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["paper", "tables", "mappo_parameters", "--budget", "smoke", "-o", "out"]) == 0
    assert "| Maps 1 to 4: Gamma | 0.92 | 0.92 | – |" in capsys.readouterr().out
