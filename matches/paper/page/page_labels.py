"""What a page says of each label: read back, so that measurements of other folders are kept where they are better."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from movingout.matches.paper.budgets import BUDGETS

HEADS = "label", "status", "budget, day", "ours (the paper's)", "n", "time", "what differs, and why"
MISSING = "not measured"  # in a cell of a table
TRAININGS = "trainings"  # behind their number, and before the error between them
_FEWER = 0.9  # of n: what newer code counts otherwise, as moments of a selection, is within it
MEASURED, IN_PART, DRAWN = "measured", "measured in part", "drawn"
_ROW, _SECTION = re.compile(r"^\| `([^`]+)` \| .*\|$", re.M), re.compile(r"^### .*\(`([^`]+)`\)$", re.M)


@dataclass(frozen=True, slots=True)
class PageLabel:
    """The row of a label, and the table of all its numbers; empty where it has none of its own."""

    row: str
    table: str = ""

    @property
    def has_numbers(self) -> bool:
        return self._cells[1] in (MEASURED, IN_PART, DRAWN)

    @property
    def budget(self) -> int:
        """Its place among the budgets, the smallest first."""
        return list(BUDGETS).index(self._cells[2].partition(",")[0])

    @property
    def day(self) -> str:
        """On which it was measured."""
        return self._cells[2].split(", ")[1]

    @property
    def trainings(self) -> int:
        """Of each agent; two or more where the page does not say how many, but has the error between them."""
        said = re.search(rf", (\d+) {TRAININGS}\b", self._cells[2])
        return int(said.group(1)) if said else 1 + (f"({TRAININGS} ±" in self.row + self.table)

    @property
    def n(self) -> int:
        """The largest count of what the row shows."""
        counts = re.findall(r"\d+", self._cells[4].replace(",", ""))
        return max(map(int, counts), default=0)

    def is_better_than(self, other: "PageLabel") -> bool:
        """Whether it has a bigger budget, or with the same is whole, has more trainings, more numbers, or a larger n.

        A bigger budget with fewer numbers is no better, but than the smallest, whose numbers mean nothing. Of another
        budget, trainings and n do not count: what agents have learned matters more than how well it is known.
        """
        if not self.has_numbers or not other.has_numbers:
            return self.has_numbers
        if self.budget == other.budget:
            return self._stands_on_more_than(other)
        smaller, bigger = sorted((self, other), key=lambda one: one.budget)
        better = smaller if smaller.budget > 0 and smaller._has_more_than(bigger) else bigger
        return better is self

    def is_as_whole_as(self, other: "PageLabel") -> bool:
        """Whether it has the same budget, and no fewer trainings or numbers, whatever n is."""
        if not self.has_numbers or not other.has_numbers or self.budget != other.budget:
            return False
        return self.trainings >= other.trainings and not other._has_more_than(self)

    def _stands_on_more_than(self, other: "PageLabel") -> bool:
        """With the same budget."""
        if (self.status == IN_PART) != (other.status == IN_PART):  # what lacks would be lost with the whole row
            return other.status == IN_PART
        if self.trainings != other.trainings:
            return self.trainings > other.trainings
        if self._has_more_than(other) or other._has_more_than(self):
            return self._has_more_than(other)
        return other.n < _FEWER * self.n

    def _has_more_than(self, other: "PageLabel") -> bool:
        if self._cells[1] != other._cells[1] and IN_PART in (self._cells[1], other._cells[1]):
            return other._cells[1] == IN_PART
        if self.table and other.table:
            return self.table.count(MISSING) < other.table.count(MISSING)
        return self._cells[3].count("; ") > other._cells[3].count("; ")

    def has_numbers_of(self, other: "PageLabel") -> bool:
        """Whether nothing but the day and the time it took is different."""
        mine, theirs = ([*one._cells[:2], one.budget, *one._cells[3:5], one.table] for one in (self, other))
        return mine == theirs

    def reworded(self, status: str, differs: str, table: str) -> "PageLabel":
        """With the same numbers."""
        label, _, *numbers, _ = self._cells
        return PageLabel(line([label, status, *numbers, differs]), table)

    @property
    def status(self) -> str:
        return self._cells[1]

    @property
    def _cells(self) -> list[str]:
        return cells_of(self.row)


def cells_of(row: str) -> list[str]:
    """Of a row of a Markdown table, as it is written."""
    return [cell.strip().replace("\\|", "|") for cell in row.strip().strip("|").split(" | ")]


def line(cells: Iterable[str]) -> str:
    """A row of a Markdown table."""
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def written_labels(text: str) -> dict[str, PageLabel]:
    """The labels of a page. Rows that another version wrote, with other columns, are left out."""
    starts = [*(one.start() for one in _SECTION.finditer(text)), len(text)]
    tables = {
        one.group(1): text[one.start() : end].strip() + "\n"
        for one, end in zip(_SECTION.finditer(text), starts[1:], strict=True)
    }
    found = {
        row.group(1): PageLabel(row.group(0), tables.get(row.group(1), ""))
        for row in _ROW.finditer(text)
        if row.group(0).count(" | ") == len(HEADS) - 1
    }
    return {label: one for label, one in found.items() if _is_readable(one)}


def _is_readable(one: PageLabel) -> bool:
    try:
        return not one.has_numbers or one.budget >= 0
    except ValueError:
        return False
