"""The tables of `recordings diversity`: Markdown to read, CSV to go on with, and what they were made with."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from movingout.maps.files.terminal import printable
from movingout.recordings.diversity.comparison import (
    MapDiversity,
    PopulationDiversity,
    Sampling,
    named,
)
from movingout.recordings.diversity.measures import DiversityOptions
from movingout.recordings.spreadsheet import safe_cells
from movingout.world.estimates import Estimate, estimate_text

Shares = Mapping[str, Estimate]  # of valid pieces, per augmented population

TITLES = ("DTW mean", "DTW variance", "entropy (KDE)", "coverage (RBF)")


def population_table(rows: Sequence[PopulationDiversity], shares: Shares | None = None) -> str:
    """A row per population: means over maps; with `shares`, what is valid of the pieces of augmented ones."""
    heads = (
        "population",
        "maps",
        "episodes",
        "distinct",
        *TITLES,
        *(("valid", "pieces") if shares is not None else ()),
    )
    cells = [
        (one.population, str(one.maps), str(one.episodes), str(one.distinct), *_texts(one), *_share_texts(one, shares))
        for one in rows
    ]
    return _markdown(heads, cells)


def population_json(row: PopulationDiversity, shares: Shares | None = None) -> dict[str, Any]:
    """The row; with `shares`, that of its valid pieces as well, None for what was recorded."""
    if shares is None:
        return row.to_json()
    mean, error, count = shares.get(row.population, (None, None, None))
    return {**row.to_json(), "valid_share": mean, "valid_share_stderr": error, "pieces": count}


def map_table(rows: Sequence[MapDiversity]) -> str:
    """A row per map and population."""
    heads = ("map", "population", "episodes", "distinct", "measured", *TITLES)
    cells = [
        (one.map, one.population, str(one.episodes), str(one.distinct), str(one.drawn or "–"), *_texts(one))
        for one in rows
    ]
    return _markdown(heads, cells)


def method(options: DiversityOptions, sampling: Sampling) -> str:
    """How the figures were made: they can only be compared with figures made in the same way."""
    counts = (
        f"of every population as many episodes as the smallest one has on that map, {sampling.draws} draws, "
        f"seed {sampling.seed}"
        if sampling.counts == "equal"
        else "all episodes of every population"
    )
    return (
        f"Paths of both robots at {options.points} moments; entropy on {options.grid} x {options.grid} cells with a "
        f"kernel of {options.bandwidth:g}, coverage with a kernel of {options.rbf_width:g} arena units; {counts}. "
        "± is the standard error by the jackknife over distinct episodes; with fewer than three there is "
        "none, with three none of the DTW variance."
    )


def write_csv(path: Path, documents: Sequence[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(documents[0]))
        writer.writeheader()
        writer.writerows(map(safe_cells, documents))


def _texts(row: MapDiversity | PopulationDiversity) -> list[str]:
    errors = named(row.error)
    return [_text(number, errors[name]) for name, number in named(row.value).items()]


def _share_texts(row: PopulationDiversity, shares: Shares | None) -> list[str]:
    if shares is None:
        return []
    share = shares.get(row.population)
    return [estimate_text(share), str(share.n if share else "–")]


def _text(number: float | None, error: float | None) -> str:
    if number is None:
        return "–"
    return f"{number:.3f}" + ("" if error is None else f" ± {error:.3f}")


def _markdown(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *(f"| {' | '.join(map(_cell, row))} |" for row in rows)])


def _cell(text: str) -> str:
    return printable(text).replace("|", "\\|")
