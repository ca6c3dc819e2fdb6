"""AC stands in tables twice: by the paper's formula, and as its code counts, each beside the paper's number."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.match import Match, MatchResult
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.page.reproduction_page import BEGIN, END, write_page
from movingout.matches.paper.presentation.layout import AC_OF_BEFORE, TWO_ACS, LaidOutTable, laid_out
from movingout.matches.paper.presentation.writers import WRITERS
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.world.metrics import Metrics

ENTRY = ENTRIES["tab:nfd_vs_ac"]
Play = Callable[[float | None, float | None], None]


@pytest.fixture
def space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Workspace:
    monkeypatch.chdir(tmp_path)
    return Workspace(budget=replace(BUDGETS["smoke"], trainings=1))


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Every match has been played, with this AC by the formula and this one by the code."""

    def played(ac: float | None, official_ac: float | None) -> None:
        def result(self: Workspace, match: Match) -> MatchResult:
            metrics = Metrics.of({"tcr": 0.5, "nfd": 0.5, "wt_s": 1.5, "ac": ac})
            return MatchResult(match, "time", 60, 0, 4, metrics, 0.03, official_ac=official_ac)

        monkeypatch.setattr(Workspace, "result", result)

    return played


def _first(table: LaidOutTable) -> tuple[str, ...]:
    return table.rows[0][3:7]


def test_ours_of_the_code_stands_behind_ours_of_the_formula(space: Workspace, play: Play) -> None:
    play(0.25, 0.75)
    table = laid_out(ENTRY, space)
    assert table.heads[3:7] == ("AC (↑) here", "paper", "AC of the code (↑) here", "paper")
    assert _first(table) == ("0.2500 ± 0.0000", "0.8615", "0.7500 ± 0.0000", "0.8615")
    assert TWO_ACS in table.notes and AC_OF_BEFORE not in table.notes
    assert "| 0.2500 ± 0.0000 | 0.8615 | 0.7500 ± 0.0000 | 0.8615 |" in WRITERS["md"](table)
    assert "<td>0.2500 ± 0.0000</td><td>0.8615</td><td>0.7500 ± 0.0000</td><td>0.8615</td>" in WRITERS["html"](table)
    assert r"AC ($\uparrow$)} & \multicolumn{3}{c}{AC of the code ($\uparrow$)}" in WRITERS["tex"](table)
    assert "0.2500 & 0.0000 & 0.8615 & 0.7500 & 0.0000 & 0.8615" in WRITERS["tex"](table)


def test_matches_of_before_have_no_value_of_the_code_and_a_note_says_so(space: Workspace, play: Play) -> None:
    play(0.25, None)
    table = laid_out(ENTRY, space)
    assert _first(table) == ("0.2500 ± 0.0000", "0.8615", "no value", "0.8615")
    assert table.notes[-3:-1] == (TWO_ACS, AC_OF_BEFORE)
    play(None, None)
    table = laid_out(ENTRY, space)
    assert _first(table)[::2] == ("no value", "no value")
    assert AC_OF_BEFORE not in table.notes, "nothing was carried together"
    assert TWO_ACS not in laid_out(ENTRIES["tab:random_partner"], space).notes


def test_a_page_of_before_gets_the_column_without_values(space: Workspace, play: Play) -> None:
    play(0.25, 0.75)
    page = Path("page.md")
    page.write_text(f"{BEGIN}\n{END}\n", encoding="utf-8")
    write_page(page, [ENTRY], space, "2026-11-27")
    kept = page.read_text(encoding="utf-8").replace("(`smoke`", "(`medium`").replace("smoke, 2026", "medium, 2026")
    kept = kept.replace(" AC of the code (↑) here | paper |", "").replace(" 0.7500 ± 0.0000 | 0.8615 |", "")
    kept = kept.replace(" 0.7500 ± 0.0000 | 0.9127 |", "").replace("0.2500", "0.3000").replace("Pairs of", "Twos of")
    page.write_text(kept, encoding="utf-8")
    write_page(page, [ENTRY], space, "2026-11-28")
    text = page.read_text(encoding="utf-8")
    assert "medium, 2026-11-27" in text and "Pairs of one agent" in text, "its words are those of today"
    assert "| AC (↑) here | paper | AC of the code (↑) here | paper | n |" in text
    assert "| 0.3000 ± 0.0000 | 0.8615 | no value | 0.8615 |" in text
    assert "| 0.3000 ± 0.0000 | 0.9127 | no value | 0.9127 |" in text
