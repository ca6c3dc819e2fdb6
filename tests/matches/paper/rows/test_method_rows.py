"""The rows of agents: who plays, and what is measured of them."""

from movingout.matches.paper.cells import MeasuredCell, Play, PlayedCell
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.registry import ENTRIES


def test_challenge_1_of_the_tcl_table_is_of_the_seen_pairs_whose_numbers_the_paper_repeats() -> None:
    plays = {
        (cell.row.name, cell.column.challenge): cell.ours.plays
        for cell in ENTRIES["tab:tcl_results"].cells()
        if isinstance(cell.ours, PlayedCell)
    }
    for name, method in (("DP/BASS", "bass"), ("DP/BASS w/ reward estimation", "bass-tcl"), ("DP", "dp")):
        assert plays[name, 1] == (Play(f"{method}@a"), Play(f"{method}@b"))
        assert plays[name, 2] == (Play(f"{method}@c2"),)


def test_a_selection_counts_only_where_the_engine_tells_candidates_apart() -> None:
    for label in ("tab:simulator", "tab:random_partner", "tab:next_state_models"):
        cells = [cell for cell in ENTRIES[label].cells() if cell.column == PublishedColumn(1, "selection")]
        for cell in cells:
            assert isinstance(cell.ours, MeasuredCell) and cell.ours.may_lack
            assert cell.ours.field == "selection_told_apart"
