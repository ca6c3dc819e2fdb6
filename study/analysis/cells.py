"""What a participant has of both of two partners: the partners are compared over that alone.

Who met one partner on easy maps only, and another on all, would else make a difference between two equal partners.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from movingout.study.analysis.questions import occasion
from movingout.study.design.definition import Study
from movingout.study.design.pooling import are_partners_in_same_blocks, are_seats_crossed, pooled_blocks

Means = dict[str, float]  # by unit or participant
Row = dict[str, Any]


class CellValue(NamedTuple):
    """What a round or an answer of a participant with a partner has to say."""

    cell: str  # what every partner is met in alike: a map, a map in a seat, a block
    value: float | None  # of rounds without a value of the metric, and of items without an answer
    source: str  # the round or the answer


CellValues = dict[str, list[CellValue]]  # by unit or participant


class Paired(NamedTuple):
    """The means of two partners over what participants have of both, and what has no counterpart."""

    first: Means
    second: Means
    left_out: frozenset[tuple[str, str]] = frozenset()  # participant and source


def paired(first: CellValues, second: CellValues) -> Paired:
    """Two partners over the cells in which each participant has a value with both, each cell with one weight for both.

    Who has no such cell is left out. Where nobody has one, these are different people: all count who have values with
    one of the two.
    """
    cells = {who: (_cells(first.get(who, ())), _cells(second.get(who, ()))) for who in (*first, *second)}
    counts = {who: one & other for who, (one, other) in cells.items()}
    if not any(counts.values()):
        counts = {who: one + other for who, (one, other) in cells.items() if not (one and other)}
    left_out = frozenset(
        (who, value.source)
        for met in (first, second)
        for who, values in met.items()
        for value in values
        if value.value is not None and value.cell not in counts.get(who, ())
    )
    return Paired(_means(first, counts), _means(second, counts), left_out)


def name_cells(study: Study, rounds: Iterable[Row], answers: Iterable[Row], units: Mapping[str, int | None]) -> None:
    """Add `cell` to rounds, which have the seat of the unit's first, and to answers; `units` are by participant."""
    groups = pooled_blocks(study)
    crossed = {block for group in groups if are_seats_crossed(study, group) for block in group}
    alike = {block for group in groups if are_partners_in_same_blocks(study, group) for block in group}
    by_step = {}
    for row in rounds:
        row["cell"] = f"{row['map']} {row['seat']}" if row["block"] in crossed else row["map"]
        by_step[row["unit"], row["step"]] = row["cell"]
    for row in answers:
        about, block = row["step"].rpartition("/")[0], row["step"].partition("/")[0]
        after_partner = block if block in alike else ""
        is_after_round = occasion(row["step"]) == "after_round"
        row["cell"] = by_step.get((units.get(row["pid"]), about), "") if is_after_round else after_partner


def _cells(values: Iterable[CellValue]) -> Counter[str]:
    """How many values there are in each cell."""
    return Counter(one.cell for one in values if one.value is not None)


def _means(met: CellValues, counts: Mapping[str, Counter[str]]) -> Means:
    """The mean of each who has one over these cells, each as often as `counts` says, however many rounds it has."""
    found = {who: _mean(values, counts.get(who, Counter())) for who, values in met.items()}
    return {who: mean for who, mean in found.items() if mean is not None}


def _mean(values: Sequence[CellValue], counts: Counter[str]) -> float | None:
    had = _cells(values)
    weighted = [
        (one.value, counts[one.cell] / had[one.cell]) for one in values if one.value is not None and one.cell in counts
    ]
    if not weighted:
        return None
    if len({weight for _, weight in weighted}) == 1:
        return sum(value for value, _ in weighted) / len(weighted)
    return sum(value * weight for value, weight in weighted) / sum(weight for _, weight in weighted)
