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


def test_the_note_of_zero_shot_coordination_says_whom_each_row_meets() -> None:
    entry = ENTRIES["tab:zsc_comparison"]
    plays = {
        cell.row.name: [play.seats[0] for play in cell.ours.plays]
        for cell in entry.cells()
        if isinstance(cell.ours, PlayedCell) and cell.column.measure == "tcr_map_12_unseen"
    }
    assert plays == {
        "DP/BASS": [("bass@a", "bass@b")],
        "MAPPO": [("mappo-12@a", "dp@b"), ("mappo-12@b", "dp@b")],
        "CoMeDi": [("comedi-12@a", "dp@b"), ("comedi-12@b", "dp@b")],
    }
    note = " ".join(entry.notes)
    assert "Unseen: DP/BASS of group a with DP/BASS of group b; MAPPO and CoMeDi with DP of group b" in note
    assert "WT" not in note and not any(cell.column.measure == "waiting_share" for cell in entry.cells())
