"""Tables as LaTeX have the paper's layout: challenges over measures, errors in columns, the best in bold."""

import re
from pathlib import Path

import pytest

from movingout.matches.match import Match, MatchResult, failed_result
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation.latex_table import latex
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate


@pytest.fixture
def space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Workspace:
    monkeypatch.chdir(tmp_path)
    return Workspace(budget=BUDGETS["smoke"])


def test_challenges_stand_over_measures_and_every_line_has_as_many_columns(space: Workspace) -> None:
    for label in ("tab:ablation", "tab:simulator", "tab:task_1_results", "mappo_parameters", "tab:w1_recombination"):
        lines = latex(laid_out(ENTRIES[label], space)).splitlines()
        (columns,) = (line[len(r"\begin{tabular}{") : -1] for line in lines if line.startswith(r"\begin{tabular}"))
        inside = lines[lines.index(r"\toprule") : lines.index(r"\bottomrule")]
        rows = [line for line in inside if line.endswith(r"\\")]
        assert len(rows) > 2 and {_width(row) for row in rows} == {len(columns)}, label
    text = latex(laid_out(ENTRIES["tab:ablation"], space))
    assert r" & \multicolumn{4}{c}{Challenge 1} & \multicolumn{4}{c}{Challenge 2} & " in text
    assert r"\multicolumn{2}{c}{NFD ($\uparrow$)}" in text and r"\cmidrule(lr){2-3}" in text


def _width(row: str) -> int:
    """How many columns a row fills."""
    spans = [int(span) for span in re.findall(r"\\multicolumn\{(\d+)\}", row)]
    return len(re.split(r"(?<!\\)&", row)) - len(spans) + sum(spans)


def test_groups_of_rows_are_told_apart_as_in_the_paper(space: Workspace) -> None:
    results = latex(laid_out(ENTRIES["tab:task_1_results"], space))
    assert r"Evaluation Protocol & Method & here" in results
    assert r"\multirow{5}{*}{Seen} & MLP & " in results and "\n & GRU & " in results
    assert r"\multirow{2}{*}{Play with Human} & DP & " in results and results.count(r"\midrule") == 3
    assert r"\cmidrule(lr){3-" in results
    ablation = latex(laid_out(ENTRIES["tab:ablation"], space))
    assert "multirow" not in ablation and ablation.count(r"\midrule") == 2 and "\n+ Full BASS & " in ablation
    settings = latex(laid_out(ENTRIES["mappo_parameters"], space))
    assert r"\multicolumn{4}{l}{\textit{Maps 1 to 4}} \\" in settings


def test_a_measure_of_both_challenges_stands_over_them(space: Workspace) -> None:
    text = latex(laid_out(ENTRIES["tab:next_state_models"], space))
    heads = [line for line in text.splitlines() if "multicolumn" in line]
    assert heads[0].startswith(
        r" & \multicolumn{4}{c}{NFD ($\uparrow$)} & \multicolumn{4}{c}{selection (prediction) accuracy"
    )
    assert heads[1].count(r"\multicolumn{2}{c}{Challenge 1}") == 2
    text = latex(laid_out(ENTRIES["tab:w1_recombination"], space))
    assert r" & \multicolumn{8}{c}{Diversity} & \multicolumn{10}{c}{Performance} & " in text
    assert "Performance" not in latex(laid_out(ENTRIES["text:augmentation"], space))


def test_errors_have_columns_and_the_best_is_bold(space: Workspace) -> None:
    for level, share in (("0.0002", 0.9), ("0.002", 0.9), ("0.02", 0.4)):
        space.keep(f"noise-by-episode-{level}", {"valid_share": Estimate(share, 0.1, 20)})
    text = latex(laid_out(ENTRIES["tab:pose_noise_ablation"], space))
    assert r"0.0002 & 0.00043 & 0.0004 & \textbf{0.9000} & 0.1000 & 0.9992 & not measured & 0.5492 & 20" in text
    assert r"0.02 & 0.043 & 0.040 & 0.4000 & 0.1000 & 0.3501 & not measured & 0.0000 & 20" in text
    assert r"0.1000 & \textbf{0.9987} & not measured & \textbf{0.6538} & 20" in text, "as the paper has it"
    assert r"Noise ($\sigma$) & here & paper & here & StdErr & paper & here & paper & n" in text
    results = latex(laid_out(ENTRIES["tab:task_1_results"], space))
    assert r"\textbf{0.3503} & 0.0293" in results, "the best of the seen, not only of all"


def test_a_table_says_which_of_its_matches_failed(space: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    def result(self: Workspace, match: Match) -> MatchResult | None:
        return failed_result(match, "red (dp@c1) took longer than 20 s") if match.map == "HandOff" else None

    assert "failed" not in latex(laid_out(ENTRIES["tab:w1_simulation"], space))
    monkeypatch.setattr(Workspace, "result", result)
    (note,) = (text for text in laid_out(ENTRIES["tab:w1_simulation"], space).notes if "failed" in text)
    assert note == (
        "3 of 36 matches failed and count as TCR 0 and NFD 0; the first, on HandOff: red (dp@c1) took longer than 20 s."
    )
