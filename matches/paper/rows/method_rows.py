"""The cells of a row: an agent with itself, two agents of disjoint groups, and what is measured of them."""

from collections.abc import Mapping

from movingout.agents.bass.recombination import Matching
from movingout.matches.paper.cells import PLAYED, PaperCell, Play, PlayedCell
from movingout.matches.paper.entry import RowCells
from movingout.matches.paper.methods import NOISE_MAP
from movingout.matches.paper.published import PublishedColumn
from movingout.matches.paper.rows.definitions import pose_shift
from movingout.matches.paper.rows.diversity import augmented_cell, diversity_cell
from movingout.matches.paper.rows.measurements import accuracy, noise_validity

_ACCURACY = {
    "selection": "selection_told_apart", "next_state_l2": "next_state_l2", "partner_10": "partner_10",
    "partner_20": "partner_20",
}  # fmt: skip
"""By column, the field of `BassAccuracy`. In a moment in which the engine scores all candidates alike, both simulators
take the first one and agree by that alone: of a selection, only moments count in which the engine tells them apart."""


def self_play(method: str, options: str = "", maps: tuple[str, ...] = ()) -> RowCells:
    """An agent with itself; columns of accuracy are measured on episodes that it has not learned from."""

    def cell(column: PublishedColumn) -> PaperCell:
        if column.measure in _ACCURACY:
            return accuracy(method, options, column.challenge, _ACCURACY[column.measure])
        agent = f"{method}@c{column.challenge}{options}"
        return PlayedCell((Play(agent),), column.challenge, column.measure, maps)

    return cell


def seen(method: str, maps: tuple[str, ...] = ()) -> RowCells:
    plays = Play(f"{method}@a"), Play(f"{method}@b")
    return lambda column: PlayedCell(plays, 1, column.measure, maps)


def unseen(method: str, maps: tuple[str, ...] = ()) -> RowCells:
    plays = (Play(f"{method}@a", f"{method}@b"),)
    return lambda column: PlayedCell(plays, 1, column.measure, maps)


def by_challenge(first: RowCells, second: RowCells) -> RowCells:
    """One kind of cells in columns of Challenge 1, another in those of Challenge 2."""
    return lambda column: (first if column.challenge == 1 else second)(column)


def bass_zero_shot(column: PublishedColumn) -> PaperCell:
    """tcr_map_12_unseen: a map by its number, and who plays."""
    _, _, number, who = column.measure.split("_")
    maps = ({"1": "HandOff", "12": "SequentialRotations"}[number],)
    make = seen if who == "seen" else unseen
    return make("bass", maps)(PublishedColumn(1, "tcr"))


def noise(level: str) -> RowCells:
    """How much of what is recorded stays valid under noise, and what an agent reaches that learned with it."""
    play = self_play(f"dp-noise-{level}", maps=(NOISE_MAP,))
    made: dict[str, PaperCell] = {"pose_shift": pose_shift(float(level)), "valid_share": noise_validity(level)}
    return lambda column: made.get(column.measure) or play(column)


def recombined(method: str, matching: Matching | None = None) -> RowCells:
    """How diverse episodes are after recombination, and what an agent reaches that learned with it."""
    play = self_play(method)

    def cell(column: PublishedColumn) -> PaperCell:
        if column.measure in PLAYED:
            return play(column)
        return augmented_cell(matching, column.measure) if matching else diversity_cell("c1", column.measure)

    return cell


def named_rows(**rows: RowCells) -> Mapping[tuple[str, str], RowCells]:
    return {("", name): cells for name, cells in rows.items()}
