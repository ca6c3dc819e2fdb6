"""The paper's figures, to compare ours with: `published.yaml` as tables.

The paper's agents were trained on people and played with themselves, across groups, or with people. Its waiting times
lie between 0 and 1, so they are not seconds, as its formula would give, but the share of ticks that the official code
counts; ours of that kind stand beside them.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, NamedTuple

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

FILE = Path(__file__).with_name("published.yaml")


_NUMBER = r"-?\d[\d,]*(\.\d+)?"
Printed = Annotated[str, Field(pattern=rf"^({_NUMBER}|[A-Za-z][\w.-]*|\[\d+(, \d+)*\])$")]  # settings may be words
PrintedChange = Annotated[str, Field(pattern=r"^[-+]\d+\.\d+$")]


class Figure(NamedTuple):
    """A mean and, where the paper gives them, its standard error and its change in % from the row compared with.

    Digit by digit as it prints them: 0.3010. Its changes differ in the last digit from those of the rounded means.
    """

    text: Printed
    error_text: Printed | None = None
    change_text: PrintedChange | None = None

    @property
    def is_number(self) -> bool:
        return re.fullmatch(_NUMBER, self.text) is not None

    @property
    def mean(self) -> float:
        return _number(self.text)

    def says(self, value: "float | str") -> bool:
        """Whether it is this setting."""
        return self.text == value if isinstance(value, str) else self.is_number and self.mean == value

    @property
    def stderr(self) -> float | None:
        return None if self.error_text is None else _number(self.error_text)


def _number(text: str) -> float:
    return float(text.replace(",", ""))


class PublishedColumn(NamedTuple):
    """A column of a table: what is measured, in which challenge (0 where the paper names neither)."""

    challenge: int
    measure: str


Figures = Mapping[PublishedColumn, Figure]


def shown_columns(columns: Iterable[PublishedColumn]) -> Iterator[tuple[PublishedColumn, PublishedColumn]]:
    """Our columns, each with the paper's that stands beside it.

    AC is there twice: by the formula that the paper prints, and as its code counts, which its numbers look like.
    """
    for column in columns:
        yield column, column
        if column.measure == "ac":
            yield column._replace(measure="official_ac"), column


class PublishedRow(NamedTuple):
    """A row of a table."""

    group: str  # of rows, empty where the table has no groups
    name: str
    figures: Figures  # of the columns in which the paper has one
    bold: tuple[PublishedColumn, ...] = ()  # in which the paper prints it bold, though another row has a better one


@dataclass(frozen=True, slots=True)
class PublishedTable:
    """A table, a figure or a sentence of the paper with numbers in it."""

    label: str
    title: str
    section: str
    about: str
    columns: tuple[PublishedColumn, ...]
    rows: tuple[PublishedRow, ...]


def _column(text: object) -> PublishedColumn:
    challenge, _, measure = str(text).partition(" ")
    return PublishedColumn(int(challenge), measure)


def _figure(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value if value is None else (value, None)


class PublishedEntry(BaseModel):
    """One entry of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: Annotated[str, Field(min_length=1)]
    section: Annotated[str, Field(min_length=1)]
    about: str = ""
    columns: tuple[Annotated[PublishedColumn, BeforeValidator(_column)], ...]
    bold: dict[str, tuple[Annotated[PublishedColumn, BeforeValidator(_column)], ...]] = {}
    rows: dict[str, dict[str, tuple[Annotated[Figure | None, BeforeValidator(_figure)], ...]]]

    def table(self, label: str) -> PublishedTable:
        return PublishedTable(label, self.title, self.section, self.about, self.columns, tuple(self._rows()))

    def _rows(self) -> Iterator[PublishedRow]:
        for group, rows in self.rows.items():
            for name, figures in rows.items():
                pairs = zip(self.columns, figures, strict=True)
                there = {column: figure for column, figure in pairs if figure is not None}
                yield PublishedRow(group, name, there, self.bold.get(name, ()))


class _NumbersAsText(yaml.SafeLoader):
    """As a number, 0.3010 would lose its last digit."""


_NumbersAsText.yaml_implicit_resolvers = {
    first: [(tag, form) for tag, form in forms if not tag.endswith((":int", ":float"))]
    for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()
}


@cache
def published_tables() -> Mapping[str, PublishedTable]:
    """All tables by label, in the order of the file."""
    document = yaml.load(FILE.read_text(encoding="utf-8"), _NumbersAsText)
    return {label: PublishedEntry.model_validate(entry).table(label) for label, entry in document.items()}


def figure(label: str, group: str, row: str, column: tuple[int, str]) -> Figure | None:
    """One figure of the paper; None where it gives none."""
    table = published_tables()[label]
    rows = [one.figures for one in table.rows if (one.group, one.name) == (group, row)]
    return rows[0].get(PublishedColumn(*column)) if rows else None
