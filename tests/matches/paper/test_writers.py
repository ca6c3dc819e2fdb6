"""Tables as LaTeX have the paper's layout: challenges over measures, errors in columns, the best in bold."""

from pathlib import Path

import pytest

from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.matches.paper.writers import latex
from movingout.world.estimates import Estimate


@pytest.fixture
def space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Workspace:
    monkeypatch.chdir(tmp_path)
    return Workspace(budget=BUDGETS["smoke"])


def test_challenges_stand_over_measures_and_every_line_has_as_many_columns(space: Workspace) -> None:
    for label in ("tab:ablation", "tab:simulator", "tab:task_1_results", "mappo_parameters"):
        lines = latex(laid_out(ENTRIES[label], space)).splitlines()
        first = next(k for k, line in enumerate(lines) if line == r"\midrule")
        (columns,) = (line.count("c", line.index("{l")) for line in lines if line.startswith(r"\begin{tabular}"))
        rows = lines[first + 1 : lines.index(r"\bottomrule")]
        assert {row.count(" & ") for row in [*rows, lines[first - 1]]} == {columns}, label
    text = latex(laid_out(ENTRIES["tab:ablation"], space))
    assert r" & \multicolumn{4}{c}{Challenge 1} & \multicolumn{4}{c}{Challenge 2} & " in text
    assert r"\multicolumn{2}{c}{NFD ($\uparrow$)}" in text and r"\cmidrule(lr){2-3}" in text


def test_errors_have_columns_and_the_best_is_bold(space: Workspace) -> None:
    for level, share in (("0.0002", 0.9), ("0.002", 0.9), ("0.02", 0.4)):
        space.keep(f"noise-{level}", {"valid_share": Estimate(share, 0.1, 20)})
    text = latex(laid_out(ENTRIES["tab:pose_noise_ablation"], space))
    assert (
        r"0.0002 & 0.00043 & 0.0004 & \textbf{0.9000} & 0.1000 & \textbf{0.9992} & not measured & 0.5492 & 20" in text
    )
    assert r"0.02 & 0.043 & 0.04 & 0.4000 & 0.1000 & 0.3501 & not measured & 0 & 20" in text
    assert " & here & paper & here & StdErr & paper & here & paper & n" in text
    results = latex(laid_out(ENTRIES["tab:task_1_results"], space))
    assert r"\textbf{0.3503} & 0.0293" in results, "the best of the seen, not only of all"
