"""One table or figure of the paper: what fills each of its cells here, or why nothing does."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from movingout.matches.paper.cells import EmptyCell, MeasuredCell, Measurement, PaperCell, PlayedCell, PooledCell
from movingout.matches.paper.presentation.drawing import Drawing, figure_file
from movingout.matches.paper.published import (
    Figure,
    PublishedColumn,
    PublishedRow,
    PublishedTable,
    published_tables,
    shown_columns,
)
from movingout.matches.paper.workspace import Workspace

Kind = Literal["table", "figure", "sentence", "illustration"]
RowGrouping = Literal["rule", "column", "line"]
"""How the paper tells groups of rows apart: by a rule alone, by a column with their names, by a line above each."""
RowCells = Callable[[PublishedColumn], PaperCell]
"""The cell of a row in a column."""


class Earlier(NamedTuple):
    """How numbers were measured that docs/reproduction.md keeps, where that is not as today."""

    before: str  # the first day on which it was as today, as 2026-11-28
    said: str  # a sentence


class EntryCell(NamedTuple):
    """A cell with the paper's figure, where it has one."""

    row: PublishedRow
    column: PublishedColumn
    theirs: Figure | None
    ours: PaperCell

    @property
    def without_number(self) -> bool:
        """Whether neither the paper nor this project has a number for it: nothing is missing here."""
        return self.theirs is None and isinstance(self.ours, EmptyCell)


@dataclass(frozen=True, kw_only=True)
class PaperEntry:
    """A label of the paper, and how it is made here."""

    label: str
    kind: Kind
    title: str = ""  # where the paper's figures have no entry in published.yaml
    rows: Mapping[tuple[str, str], RowCells] = field(default_factory=dict)  # by group and name
    otherwise: str = ""  # why other rows are empty, or nothing is made
    lacks: str = ""  # what the paper's figure shows besides, of which it prints no numbers, and why it is not here
    command: str = ""  # another command that makes it
    extra: str = ""  # of the installation, without which it cannot be made
    people: bool = False  # whether only people can fill it
    own_episodes: bool = False  # whether it learns from other episodes than those of the workspace
    drawing: Drawing | None = None  # of a figure without numbers
    differs: str = ""  # in a phrase, what differs from the paper and why
    notes: tuple[str, ...] = ()  # what to know of its numbers, in sentences
    folder_notes: Callable[[Workspace], list[str]] = lambda space: []  # what to know of the episodes of a folder
    earlier: Earlier | None = None
    against: Mapping[str, str] = field(default_factory=dict)  # by group: that which changes in % are relative to
    grouping: RowGrouping = "rule"
    row_heads: tuple[str, ...] = ("Method",)  # over the names of rows, and before it over those of groups
    extra_rows: tuple[PublishedRow, ...] = ()  # that the paper does not have

    @property
    def published(self) -> PublishedTable | None:
        """Its numbers in the paper; None for a picture without."""
        return published_tables().get(self.label)

    @property
    def heading(self) -> str:
        return self.title or (self.published.title if self.published else "")

    def cells(self) -> Iterator[EntryCell]:
        """Row by row. Rows without an entry are empty, and say why."""
        if self.published is None:
            return
        for row in (*self.published.rows, *self.extra_rows):
            make = self.rows.get((row.group, row.name))
            for column, theirs in shown_columns(self.published.columns):
                ours = make(column) if make else EmptyCell(self.otherwise)
                yield EntryCell(row, column, row.figures.get(theirs), ours)

    @property
    def state(self) -> str:
        """Made here whole, in part, by another command, or not at all."""
        if self.drawing:
            return "whole"
        if self.kind == "illustration":
            return "illustration"
        cells = [cell.ours for cell in self.cells() if not cell.without_number]
        filled = sum(not isinstance(cell, EmptyCell) for cell in cells)
        if cells and filled == len(cells) and not self.lacks:
            return "whole"
        return "in part" if filled else "elsewhere" if self.command else "not done"

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be said below the table or figure: its notes, and what differs from the paper."""
        return (*self.notes, *([f"What differs from the paper: {self.differs}."] if self.differs else []))

    def drawn(self) -> bool:
        """Whether the current folder has the picture."""
        return self.drawing is not None and figure_file(self.label, "png").exists()

    @property
    def runnable(self) -> bool:
        return self.state in ("whole", "in part")


def played_cells(entries: "list[PaperEntry]") -> list[PlayedCell]:
    """The cells of entries that are filled by matches."""
    found: list[PlayedCell] = []
    for cell in (cell.ours for entry in entries for cell in entry.cells()):
        if isinstance(cell, PlayedCell):
            found.append(cell)
        elif isinstance(cell, PooledCell):
            found += cell.parts
    return found


def measurements(entries: "list[PaperEntry]") -> list[Measurement]:
    """What entries measure, each once."""
    cells = [cell.ours for entry in entries for cell in entry.cells()]
    return list({one.measurement.name: one.measurement for one in cells if isinstance(one, MeasuredCell)}.values())
