"""A table as text: the paper's rows and columns, its figure and ours side by side."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

from movingout.matches.match import MatchResult
from movingout.matches.paper.cells import DefinedCell, EmptyCell, Found, MeasuredCell
from movingout.matches.paper.entry import EntryCell, PaperEntry, RowGrouping, played_cells
from movingout.matches.paper.pooling import of_the_same_samples
from movingout.matches.paper.presentation.given_note import given_notes, people_notes
from movingout.matches.paper.presentation.group_note import group_notes
from movingout.matches.paper.published import Figure, PublishedColumn
from movingout.matches.paper.rows.data_sizes import SizeCell
from movingout.matches.paper.workspace import Workspace
from movingout.matches.results.other_code import MIXED, is_mixed
from movingout.matches.results.table import COPIES
from movingout.recordings.diversity.comparison import MEASURES as DIVERSITY

HEADINGS = {
    "tcr": "TCR (↑)", "nfd": "NFD (↑)", "waiting_share": "WT (↓)", "ac": "AC (↑)",
    "official_ac": "AC of the code (↑)",
    "selection": "selection (prediction) accuracy (↑)", "next_state_l2": "L2 (↓)",
    "partner_10": "within 10 % (↑)", "partner_20": "within 20 % (↑)", "valid_share": "valid (↑)",
    "dtw_mean": "DTW mean (↑)", "dtw_variance": "DTW variance (↑)",
    "entropy": "entropy (↑)", "coverage": "coverage (↑)",
    "tcr_map_1_seen": "map 1 seen", "tcr_map_1_unseen": "map 1 unseen",
    "tcr_map_12_seen": "map 12 seen", "tcr_map_12_unseen": "map 12 unseen",
    "tcr_map_6": "TCR, map 6 (↑)", "tcr_map_11": "TCR, map 11 (↑)",
    "nfd_map_6": "NFD, map 6 (↑)", "least_hours": "at least [h]", "most_hours": "at most [h]",
    "map_6_middle_first": "map 6: middle-sized first", "map_6_first_grasp_s": "map 6: first grasp [s]",
    "map_11_first_grasp_s": "map 11: first grasp [s]", "map_11_first_shared_s": "map 11: first shared item [s]",
    "pose_shift": "pose shift", "value": "value", "participants": "participants", "p_value": "p",
    "decision_ms": "decision [ms]", "change": "change",
    "score": "score (↑)", "score_gain": "score above DP's",
    "no_handover": "no handover", "no_help": "no help", "no_grasp": "no grasp",
}  # fmt: skip
NO_VALUE = "no value"  # in a cell, of what was played
NOT_REPRODUCED = (
    "The paper's agents learned from people, on other hardware. Equal numbers do not mean that a result was "
    "reproduced, and different ones do not mean that it was not."
)
BETWEEN = (
    "Every agent was trained {0} times. The first ± takes all matches or samples for independent; behind it stands the "
    "standard error between the means of the trainings, n = {0}."
)
TWO_ACS = (
    "AC is by the paper's formula; its numbers look more like AC of the code, which counts something else under that "
    "name (docs/metrics.md)."
)
AC_OF_BEFORE = "Matches that were played before AC of the code was counted have no value of it."


class CellText(NamedTuple):
    """A number as it is written."""

    value: str
    error: str = ""  # its standard error
    behind: str = ""  # the error between trainings, and the change from another row
    best: bool = False  # of its column in its group of rows

    @property
    def text(self) -> str:
        return self.value + (f" ± {self.error}" if self.error else "") + self.behind


@dataclass(frozen=True, slots=True)
class LaidOutTable:
    """Headings, rows of text, and the notes below; the numbers also one by one."""

    label: str
    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...]
    columns: tuple[PublishedColumn, ...] = ()
    numbers: tuple[tuple[CellText, ...], ...] = ()  # of each row, ours and theirs of each column
    names: tuple[tuple[str, str], ...] = ()  # of each row, its group and its own
    grouping: RowGrouping = "rule"
    row_heads: tuple[str, ...] = ()


def laid_out(entry: PaperEntry, space: Workspace) -> LaidOutTable:
    """The table of an entry, with whatever has been played and measured so far."""
    cells = list(entry.cells())
    columns = list(dict.fromkeys(cell.column for cell in cells))
    found = {_key(cell): cell.ours.found(space) for cell in cells}
    many = len({column.challenge for column in columns}) > 1
    heads = ["", *(part for column in columns for part in (f"{column_head(column, many)} here", "paper")), "n"]
    lines = [cells[start : start + len(columns)] for start in range(0, len(cells), len(columns))]
    best = _best(cells, found)
    numbers = [tuple(text for cell in line for text in _texts(cell, found, entry, best)) for line in lines]
    rows = [
        (_row_name(line[0]), *(one.text for one in texts), _count(line, found))
        for line, texts in zip(lines, numbers, strict=True)
    ]
    return LaidOutTable(
        entry.label, entry.heading, tuple(heads), tuple(rows), tuple(_notes(entry, space, cells, found)),
        tuple(columns), tuple(numbers), tuple((line[0].row.group, line[0].row.name) for line in lines),
        entry.grouping, entry.row_heads,
    )  # fmt: skip


def _row_name(cell: EntryCell) -> str:
    return f"{cell.row.group}: {cell.row.name}" if cell.row.group else cell.row.name


Key = tuple[str, str, PublishedColumn]
FoundCells = dict[Key, Found | None]


def _key(cell: EntryCell) -> Key:
    return cell.row.group, cell.row.name, cell.column


def column_head(column: PublishedColumn, many: bool) -> str:
    """The heading of a column, with the challenge where a table has several."""
    measure = HEADINGS.get(column.measure, column.measure)
    return f"C{column.challenge} {measure}" if many and column.challenge else measure


def _texts(cell: EntryCell, found: FoundCells, entry: PaperEntry, best: "Best") -> tuple[CellText, CellText]:
    """Ours and theirs, each with the change from the row that it is compared with."""
    group = entry.against.get(cell.row.group)
    ours, theirs = found[_key(cell)], cell.theirs
    before = found.get((group, cell.row.name, cell.column)) if group is not None else None
    missing = ours is None and not isinstance(cell.ours, EmptyCell)
    here = CellText("not measured") if missing else _number(ours)
    change = _change(_mean(before), _mean(ours))
    said = f" ({theirs.change_text} %)" if theirs and theirs.change_text else ""
    place = cell.row.group, cell.column
    return (
        here._replace(behind=here.behind + change, best=_mean(ours) is not None and _mean(ours) == best[0].get(place)),
        _published(theirs)._replace(
            behind=said, best=theirs is not None and theirs.is_number and theirs.mean == best[1].get(place)
        ),
    )


Best = tuple[dict[tuple[str, PublishedColumn], float], dict[tuple[str, PublishedColumn], float]]
"""By group of rows and column, the best number of ours and of theirs."""


def _best(cells: Sequence[EntryCell], found: FoundCells) -> Best:
    """Only where numbers differ, and where more or less is better."""
    ours: defaultdict[tuple[str, PublishedColumn], set[float]] = defaultdict(set)
    theirs: defaultdict[tuple[str, PublishedColumn], set[float]] = defaultdict(set)
    for cell in cells:
        place = cell.row.group, cell.column
        if (mean := _mean(found[_key(cell)])) is not None:
            ours[place].add(mean)
        if cell.theirs is not None and cell.theirs.is_number:
            theirs[place].add(cell.theirs.mean)
    return _extremes(ours), {**_extremes(theirs), **_bold(cells)}


def _bold(cells: Sequence[EntryCell]) -> dict[tuple[str, PublishedColumn], float]:
    """What the paper prints bold though it is not the best."""
    return {
        (cell.row.group, cell.column): cell.theirs.mean
        for cell in cells
        if cell.theirs is not None and cell.column in cell.row.bold
    }


def _extremes(values: Mapping[tuple[str, PublishedColumn], set[float]]) -> dict[tuple[str, PublishedColumn], float]:
    directions = {"↑": max, "↓": min}
    return {
        place: directions[arrow](numbers)
        for place, numbers in values.items()
        if len(numbers) > 1 and (arrow := HEADINGS.get(place[1].measure, "")[-2:-1]) in directions
    }


def _mean(found: Found | None) -> float | None:
    return None if found is None or found.estimate is None else found.estimate.mean


def number_text(found: Found | None) -> str:
    """Our number with its standard errors."""
    return _number(found).text


def _number(found: Found | None) -> CellText:
    if found is None:
        return CellText("–")
    if found.defined is not None:
        return CellText(plain(found.defined))
    if found.estimate is None:
        return CellText(NO_VALUE)
    error, between = found.estimate.stderr, found.between.stderr if found.between else None
    return CellText(
        f"{found.estimate.mean:.4f}",
        "" if error is None else f"{error:.4f}",
        "" if between is None else f" (trainings ± {between:.4f})",
    )


def paper_text(figure: Figure | None) -> str:
    """The paper's number as it prints it."""
    return _published(figure).text


def _published(figure: Figure | None) -> CellText:
    if figure is None:
        return CellText("–")
    return CellText(figure.text, figure.error_text or "")


def plain(value: float | str) -> str:
    """Without an exponent: 0.00005, 30,000,000. Words as they are."""
    if isinstance(value, str):
        return value
    return f"{value:,.0f}" if abs(value) >= 1e4 else f"{Decimal(repr(value)).normalize():f}"


def _change(before: float | None, now: float | None) -> str:
    """The change in %; empty where `before` is 0, or below as an NFD may be: no share of that means anything."""
    if before is None or before <= 0 or now is None:
        return ""
    return f" ({100 * (now - before) / before:+.2f} %)"


def _count(row: Sequence[EntryCell], found: FoundCells) -> str:
    """How much stands behind a row: the counts of its cells, each once, with distinct episodes."""
    texts = []
    for cell in row:
        one = found[_key(cell)]
        if one is not None and one.estimate is not None:
            copies = one.distinct is not None and one.distinct < one.estimate.n
            texts.append(f"{one.estimate.n}" + (f" ({one.distinct} distinct)" if copies else ""))
    settings = all((one := found[_key(cell)]) is not None and one.defined is not None for cell in row)
    return ", ".join(dict.fromkeys(texts)) or ("–" if settings else "0")


def _of_groups(cell: EntryCell) -> bool:
    """Whether its agents learned from a group of people."""
    return any(agent_id.endswith(("@a", "@b")) for agent_id in cell.ours.agents)


def _notes(entry: PaperEntry, space: Workspace, cells: Sequence[EntryCell], found: FoundCells) -> list[str]:
    made = _of_settings(cells, space) if is_of_settings(cells) else _of_what_was_made(entry, space, cells)
    notes = [*made, *entry.remarks, *entry.folder_notes(space)]
    if entry.published and entry.published.about:
        notes.append(entry.published.about)
    empty = {cell.row.name: cell.ours.reason for cell in cells if isinstance(cell.ours, EmptyCell) and cell.ours.reason}
    reasons = {reason: [name for name in empty if empty[name] == reason] for reason in empty.values()}
    notes += [f"Not done here: {', '.join(names)}: {reason}." for reason, names in reasons.items()]
    notes += [f"Not done here: {entry.lacks}."] if entry.lacks else []
    return notes if is_of_settings(cells) else [*notes, *_about_numbers(entry, space, cells, found)]


def is_of_settings(cells: Sequence[EntryCell]) -> bool:
    """Whether nothing is played or measured, so that no budget and no error matters."""
    return all(isinstance(cell.ours, DefinedCell) for cell in cells)


def _of_settings(cells: Sequence[EntryCell], space: Workspace) -> list[str]:
    return given_notes(space, {cell.ours.challenge for cell in cells if isinstance(cell.ours, SizeCell)})


def _of_what_was_made(entry: PaperEntry, space: Workspace, cells: Sequence[EntryCell]) -> list[str]:
    """How much was made, and from whose episodes."""
    whose = [] if entry.own_episodes else people_notes(space, {cell.column.challenge for cell in cells})
    notes = [space.budget.sentence, *whose, NOT_REPRODUCED]
    if any(cell.column.challenge == 2 for cell in cells):
        notes.append(
            "Challenge 2: trained on varied maps, evaluated on the maps as designed."
            if space.evaluation == "official"
            else "Challenge 2: trained and evaluated on varied maps that share no combination of size and shape."
        )
    return [*notes, *(group_notes(space) if any(_of_groups(cell) for cell in cells) else [])]


def _about_numbers(entry: PaperEntry, space: Workspace, cells: Sequence[EntryCell], found: FoundCells) -> Iterator[str]:
    """What ± and n are, and what is to be known of the matches."""
    results = _results(entry, space)
    yield from _failures(results)
    if is_mixed(filter(None, results)):
        yield MIXED
    if any("distinct" in _count([cell], found) for cell in cells):
        yield COPIES
    trainings = {one.between.n for one in found.values() if one is not None and one.between is not None}
    if trainings:
        yield BETWEEN.format(max(trainings))
    measures = {cell.column.measure for cell in cells}
    yield from _about_ac(results) if "ac" in measures else []
    yield from _about_errors(measures)
    yield from _about_moments(cells)


def _about_ac(results: Sequence[MatchResult | None]) -> list[str]:
    """What its two columns are, and whether the second lacks matches of before."""
    before = any(one is not None and one.metrics.ac is not None and one.official_ac is None for one in results)
    return [TWO_ACS, *([AC_OF_BEFORE] if before else [])]


def _about_moments(cells: Sequence[EntryCell]) -> list[str]:
    """What ± and n are where moments of episodes are measured, of all trainings the same but where they choose."""
    pools = [cell.ours.measurement.pool for cell in cells if isinstance(cell.ours, MeasuredCell)]
    if of_the_same_samples not in pools:
        return []
    return [
        "Of what is measured in moments, ± takes those of an episode together; n counts them once for all trainings. "
        "Of choices, which are told apart in other moments for each training, it is that of the training with most."
    ]


def _about_errors(measures: Set[str]) -> list[str]:
    """What ± and n of these measures are."""
    of_paths = (
        "Of diversity, ± is the jackknife's standard error over distinct paths, combined over maps; n counts paths."
    )
    others = measures - set(DIVERSITY)
    said = ["± is the standard error over matches or samples; n counts them."] if others or not measures else []
    return [*said, *([of_paths] if measures - others else [])]


def _results(entry: PaperEntry, space: Workspace) -> list[MatchResult | None]:
    """Of each match of an entry; None where it has not been played."""
    matches = dict.fromkeys(match for cell in played_cells([entry]) for match in cell.matches(space))
    return [space.result(match) for match in matches]


def _failures(results: Sequence[MatchResult | None]) -> list[str]:
    """A sentence on matches that could not be played to the end, which pull TCR and NFD down; else nothing."""
    failed = [one for one in results if one is not None and one.ending == "failed"]
    if not failed:
        return []
    number = f"{len(failed):,} of {len(results):,} matches failed and count{'s' * (len(failed) == 1)}"
    return [f"{number} as TCR 0 and NFD 0; the first, on {failed[0].match.map}: {failed[0].failure}."]
