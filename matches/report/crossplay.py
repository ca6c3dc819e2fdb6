"""Cross-play: how well agents do with each partner, as matrices, and the worst matches with where to look in them."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from movingout.matches.grid_run import GridRun
from movingout.matches.match import MatchResult
from movingout.matches.results.significance import evidence, holm, welch
from movingout.matches.results.table import Measure, ResultRow
from movingout.recordings import RecordingError, read_episode
from movingout.recordings.report.failures import failures
from movingout.recordings.report.track import Track
from movingout.recordings.report.waiting import waits
from movingout.recordings.report.words import Words
from movingout.world.estimates import Estimate

WORST = 12  # matches listed
MOMENTS = 4  # per match


@dataclass(frozen=True, slots=True)
class Cell:
    """An agent (row) with a partner (column)."""

    estimate: Estimate | None
    best: bool  # of its column
    p: float | None  # that it equals the best of its column, Welch with Holm's correction in the column
    distinct: int | None = None  # episodes that are no copies of others; None where that is unknown


@dataclass(frozen=True, slots=True)
class Matrix:
    """One metric on one map: cells by (agent, partner)."""

    measure: Measure
    agents: tuple[str, ...]
    partners: tuple[str, ...]
    cells: dict[tuple[str, str], Cell]

    def strength(self, found: Estimate | None) -> float:
        """How good a value is among all cells of the matrix, in [0, 1]."""
        means = [cell.estimate.mean for cell in self.cells.values() if cell.estimate is not None]
        if found is None or max(means) == min(means):
            return 0.0
        share = (found.mean - min(means)) / (max(means) - min(means))
        return share if self.measure.more_is_better else 1.0 - share


@dataclass(frozen=True, slots=True)
class MatchMoment:
    """A tick of a match that is worth looking at."""

    tick: int
    text: str


def matrix(rows: Iterable[ResultRow], measure: Measure) -> Matrix:
    """The matrix of the rows of one condition, challenge and map."""
    rows = list(rows)
    found = {(row.agent, row.partner): row for row in rows}
    agents = tuple(dict.fromkeys(agent for agent, _ in found))
    partners = tuple(dict.fromkeys(partner for _, partner in found))
    cells: dict[tuple[str, str], Cell] = {}
    for partner in partners:
        column = {agent: found[agent, partner] for agent in agents if (agent, partner) in found}
        cells |= {(agent, partner): cell for agent, cell in _judged(column, measure).items()}
    return Matrix(measure, agents, partners, cells)


def _judged(column: dict[str, ResultRow], measure: Measure) -> dict[str, Cell]:
    """Each value of a column compared with the best."""
    sign = 1.0 if measure.more_is_better else -1.0
    found = {agent: row.estimate(measure) for agent, row in column.items()}
    means = {agent: sign * one.mean for agent, one in found.items() if one is not None}
    best = max(means, key=means.__getitem__) if len(set(means.values())) > 1 else ""
    shown = {agent: evidence(row.results, measure) for agent, row in column.items()}
    corrected = holm([None if not best or agent == best else welch(shown[best], one) for agent, one in shown.items()])
    return {
        agent: Cell(found[agent], agent == best, p, row.distinct)
        for (agent, row), p in zip(column.items(), corrected, strict=True)
    }


def worst_matches(run: GridRun) -> list[MatchResult]:
    """Lost matches first; then the worst of each pairing, the second worst of each, and so on.

    Matches in which everything was delivered are left out.
    """
    pairings = {entry.match: (entry.condition, entry.agent, entry.partner) for entry in run.plan}
    ranks: Counter[tuple[str, str, str]] = Counter()
    order: list[tuple[bool, int, MatchResult]] = []
    bad = [result for result in run.results.values() if result.ending != "delivered"]
    for result in sorted(bad, key=lambda one: (one.metrics.tcr, one.metrics.nfd, one.match.id)):
        pairing = pairings[result.match]
        order.append((result.ending != "failed", ranks[pairing], result))
        ranks[pairing] += 1
    return [result for _, _, result in sorted(order, key=lambda one: one[:2])[:WORST]]


def moments(run: GridRun, result: MatchResult, words: Words) -> list[MatchMoment]:
    """Where to look: the fault, the failure cases found and the longest waits; empty without a recording."""
    if result.ending == "failed":
        return [MatchMoment(result.ticks, result.failure)]
    path = Path(run.folder, result.recording)
    if not result.recording or not path.is_file():
        return []
    try:
        track = Track.of(read_episode(path))
    except RecordingError:
        return []
    found = [
        MatchMoment(
            one.start,
            words.say("grid.case", case=words.say(f"case.{one.case}"), seconds=round(one.seconds)),
        )
        for one in failures(track)
    ]
    longest = sorted(waits(track), key=lambda wait: wait.start - wait.end)
    found += [MatchMoment(one.start, words.say("grid.waits", seconds=round(one.seconds))) for one in longest[:1]]
    return sorted(found, key=lambda moment: moment.tick)[:MOMENTS]
