"""The paper's numbers are its own, and every label of it has an entry whose rows exist."""

import re
from decimal import Decimal
from pathlib import Path

import pytest

from movingout.matches.errors import MatchError
from movingout.matches.experiment.paper_reference import paper_figures, paper_tables
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import EmptyCell
from movingout.matches.paper.methods import METHODS, trained_before, trained_id, with_seed
from movingout.matches.paper.presentation.layout import laid_out, paper_text
from movingout.matches.paper.published import Figure, figure, published_tables
from movingout.matches.paper.registry import ENTRIES, chosen_entries
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate
from tests.support import ROOT

PAPER = next(
    (folder / "shared" / "paper.tex" for folder in (ROOT, ROOT.parent) if (folder / "shared").exists()), ROOT / "no"
)
needs_paper = pytest.mark.skipif(not PAPER.exists(), reason="the paper's text is not on this machine")


def _stands(figure: str, text: str) -> bool:
    """Whether the paper prints it, or prints it in per cent."""
    forms = [figure]
    if Figure(figure).is_number:
        forms.append(f"{Decimal(figure.replace(',', '')).scaleb(2):f}\\%")
    return any(re.search(rf"(?<![\w.]){re.escape(one)}(?!\w)", text) for one in forms)


@needs_paper
def test_every_figure_stands_in_the_paper() -> None:
    text = PAPER.read_text(encoding="utf-8")
    for table in published_tables().values():
        for row in table.rows:
            for one in row.figures.values():
                assert all(_stands(part, text) for part in one if part), (table.label, row.name, one)


def test_figures_keep_their_last_zeros_in_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = figure("tab:task_1_results", "Unseen", "DP/BASS", (1, "tcr"))
    assert found is not None and (found.mean, found.stderr) == (0.301, 0.0223)
    assert paper_text(found) == "0.3010 ± 0.0223"
    table = laid_out(ENTRIES["tab:task_1_results"], Workspace(budget=BUDGETS["smoke"]))
    assert any("0.3010 ± 0.0223" in cell for row in table.rows for cell in row)
    frames = figure("mappo_parameters", "", "Max Frames", (0, "value"))
    assert frames is not None and (frames.mean, paper_text(frames)) == (30e6, "30,000,000")


@pytest.mark.parametrize(
    ("label", "group", "row", "changes"),
    [
        ("tab:task_1_results", "Unseen", "MAPPO", ["-15.19", "-11.74", "+10.64", "-2.95", "-2.95"]),
        ("table:task_1_results", "Unseen", "MLP", ["-32.61", "-19.22", "+15.33", "-3.54", "-3.54"]),
        ("tab:cross_group_eval", "Cross-Group", "DP/BASS", ["-14.07", "-9.22", "+8.37", "-2.86", "-2.86"]),
    ],
)
def test_changes_are_those_that_the_paper_prints(
    label: str, group: str, row: str, changes: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the rounded means, they would be -15.24 and so on. That of AC stands beside both of ours."""
    monkeypatch.chdir(tmp_path)
    table = laid_out(ENTRIES[label], Workspace(budget=BUDGETS["smoke"]))
    (cells,) = (one for one in table.rows if one[0] == f"{group}: {row}")
    assert [cell.rpartition("(")[2] for cell in cells[2:-1:2]] == [f"{change} %)" for change in changes]


def test_validity_is_measured_of_both_ways_to_recombine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    for matching, share in (("both-ends", 0.75), ("either-end", 0.5)):
        space.keep(f"diversity-of-{matching}", {"valid_share": Estimate(share, 0.1, 20)})
    rows = {row[0]: row[1] for row in laid_out(ENTRIES["text:augmentation"], space).rows}
    assert rows == {"Recorded": "–", "Recombined": "0.7500 ± 0.1000", "Recombined, single-agent": "0.5000 ± 0.1000"}


@needs_paper
def test_every_label_of_the_paper_has_an_entry() -> None:
    lines = [line for line in PAPER.read_text(encoding="utf-8").splitlines() if not line.lstrip().startswith("%")]
    labels = set(re.findall(r"\\label\{((?:tab|table|fig):[^}]+|mappo_parameters)\}", "\n".join(lines)))
    assert labels - set(ENTRIES) == set()


def test_rows_of_entries_are_rows_of_the_paper_and_empty_cells_say_why() -> None:
    for entry in ENTRIES.values():
        assert entry.heading and (entry.published is not None or not entry.rows), entry.label
        if entry.published is not None:
            rows = {(row.group, row.name) for row in (*entry.published.rows, *entry.extra_rows)}
            assert set(entry.rows) <= rows, entry.label
            assert set(entry.against) | set(entry.against.values()) <= {group for group, _ in rows}
        for cell in entry.cells():
            assert not isinstance(cell.ours, EmptyCell) or cell.ours.reason, (entry.label, cell.row.name)
            assert all(trained_id(agent) for agent in cell.ours.agents)
        if entry.state == "not done":
            assert entry.otherwise, entry.label


def test_the_same_result_in_two_tables_is_the_same_number() -> None:
    full = figure("tab:full_results_in_t1", "DP", "+ Full BASS", (1, "tcr"))
    assert full == Figure("0.5027", "0.0619")
    assert figure("tab:ablation", "DP", "+ Full BASS", (1, "tcr")) == Figure("0.5027")
    assert figure("tab:ablation", "DP", "no such row", (1, "tcr")) is None


def test_grids_name_tables_as_before() -> None:
    methods = "tab:full_results_in_t1, _t2: DP"
    assert methods in paper_tables() and "tab:full_results_in_t2: Challenge 2" in paper_tables()
    assert paper_figures(methods, 2, "+ Full BASS")["tcr"] == Figure("0.4348", "0.0599")
    assert paper_figures("tab:full_results_in_t2: Challenge 2", 2, "MLP")["nfd"] == Figure("0.3602", "0.0315")
    assert paper_figures("tab:random_partner: BASS", 1, "BASS") == {"tcr": Figure("0.5027")}
    assert paper_figures("no such table", 1, "BASS") == {}


def test_an_unknown_label_is_refused_with_the_one_that_was_probably_meant() -> None:
    with pytest.raises(MatchError, match=r"'tab:ablatoin'; did you mean tab:ablation\? `movingout paper list`"):
        chosen_entries(["tab:ablation", "tab:ablatoin"])
    with pytest.raises(MatchError, match="the paper has no label 'zzz'; `movingout paper list` has all"):
        chosen_entries(["zzz"])
    all_labels = {entry.label for entry in chosen_entries(["all"])}
    assert all_labels >= {"tab:ablation", "tab:task_1_results", "fig:results_t2"}


def test_several_labels_are_made_in_the_order_given_each_once() -> None:
    several = ["tab:nfd_vs_ac", "tab:ablation", "tab:nfd_vs_ac"]
    assert [entry.label for entry in chosen_entries(several)] == ["tab:nfd_vs_ac", "tab:ablation"]
    assert chosen_entries([*several, "all"]) == chosen_entries(["all"])


def test_ids_have_a_method_episodes_and_a_seed() -> None:
    assert trained_id("bass@c1-2:sampling=4x4") == ("bass", "c1", 2)
    assert with_seed("dp@a:lag=1", 2) == "dp@a-2:lag=1" and with_seed("dp@a", 0) == "dp@a"
    assert [one.text for one in trained_before(trained_id("bass-plain@b"))] == [
        "dp@b", "dp-augmented@b", "bass@b",
    ]  # fmt: skip
    with pytest.raises(MatchError, match="did you mean dp@c1"):
        trained_id("dp@c11")


def test_an_agent_is_made_of_methods_that_exist() -> None:
    for name, method in METHODS.items():
        assert {method.base, method.simulator} - {""} <= set(METHODS), name
        assert bool(method.base) == (method.kind == "bass")


def test_the_page_about_reproduction_has_a_row_for_every_label_with_numbers() -> None:
    page = (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8")
    missing = [
        entry.label for entry in ENTRIES.values() if entry.kind != "illustration" and f"| `{entry.label}` |" not in page
    ]
    assert missing == []
