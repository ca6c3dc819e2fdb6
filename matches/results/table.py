"""Results as rows: mean ± standard error per condition, agent, partner and map; as Markdown and JSON."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple

from movingout.matches.experiment.plan import PlannedMatch
from movingout.matches.match import Match, MatchResult
from movingout.matches.results.unanswered import UNANSWERED, UNCOUNTED, have_uncounted_questions, unanswered
from movingout.world.estimates import Estimate, estimate_of_copies, estimate_text
from movingout.world.metrics import METRICS
from movingout.world.own_metrics import own_metrics

ALL_MAPS = "all maps"
COPIES = (
    "Episodes that are not distinct are copies of others, action by action: nothing in them depends on the seed. "
    "± counts each episode once; more seeds add nothing."
)
EARLIER = (
    "Some matches were played by an earlier version, which noted less: a measure that they lack is of the others "
    "alone, and where copies among them cannot be told, ± may be too small."
)


class Measure(NamedTuple):
    """One column: its heading, whether more is better, and its value of a result (None: it has none)."""

    key: str
    heading: str
    more_is_better: bool
    value: Callable[[MatchResult], float | None]
    title: str


def _own(key: str) -> Callable[[MatchResult], float | None]:
    return lambda result: result.own_metrics.get(key)


MEASURES = (
    *(
        Measure(metric.key, metric.heading, metric.higher_is_better, attrgetter(f"metrics.{metric.key}"), metric.title)
        for metric in METRICS
    ),
    *(
        Measure(metric.key, metric.heading, metric.higher_is_better, _own(metric.key), metric.title)
        for metric in own_metrics()
    ),
)
WAITING = Measure("waiting_share", "WT [share]", False, lambda result: result.waiting_share, "Waiting time")
"""Waiting as the official code counts it, a share of the ticks: for comparison with the paper, in no table of ours."""
OFFICIAL_AC = Measure("official_ac", "AC of the code", True, lambda result: result.official_ac, "Action consistency")
"""Action consistency as the official code counts it, for the same."""


@dataclass(frozen=True, slots=True)
class ResultRow:
    """One cell of a grid, or of several maps together."""

    condition: str
    challenge: int
    agent: str
    partner: str
    map: str
    results: tuple[MatchResult, ...]

    @property
    def failed(self) -> int:
        return sum(result.ending == "failed" for result in self.results)

    @property
    def distinct(self) -> int | None:
        return distinct(self.results)

    @property
    def count_text(self) -> str:
        return count_text(self.results)

    def estimate(self, measure: Measure) -> Estimate | None:
        return estimate_of(self.results, measure)

    def to_json(self) -> dict[str, Any]:
        ticks = [result.ticks for result in self.results]
        return {
            "condition": self.condition,
            "challenge": self.challenge,
            "agent": self.agent,
            "partner": self.partner,
            "map": self.map,
            "episodes": len(self.results),
            "distinct": self.distinct,
            "failed": self.failed,
            "full_deliveries": sum(result.ending == "delivered" for result in self.results),
            "mean_ticks": sum(ticks) / len(ticks),
            **{measure.key: estimate_json(self.estimate(measure)) for measure in MEASURES},
        }


def rows_of(plan: Iterable[PlannedMatch], results: Mapping[Match, MatchResult]) -> list[ResultRow]:
    """A row per cell, and one over all maps where there are several; in the order of the plan."""
    cells: dict[tuple[str, int, str, str, str], list[MatchResult]] = defaultdict(list)
    for entry in plan:
        result = results.get(entry.match)
        if result is not None:
            match = entry.match
            for name in (ALL_MAPS, match.map):
                cells[entry.condition, match.challenge, entry.agent, entry.partner, name].append(result)
    maps = {key[-1] for key in cells} - {ALL_MAPS}
    rows = [ResultRow(*key, tuple(found)) for key, found in cells.items() if len(maps) > 1 or key[-1] != ALL_MAPS]
    return sorted(rows, key=lambda row: row.map != ALL_MAPS)


def markdown(rows: Sequence[ResultRow]) -> str:
    """A table for people and for papers."""
    heads = ["condition", "challenge", "map", "agent", "partner", "n", *(m.heading for m in MEASURES), "failed"]
    lines = [markdown_line(heads), markdown_line(["---"] * 5 + ["--:"] * (len(heads) - 5))]
    for row in rows:
        names = [row.condition, str(row.challenge), row.map, row.agent, row.partner]
        estimates = [estimate_text(row.estimate(measure)) for measure in MEASURES]
        lines.append(markdown_line([*names, row.count_text, *estimates, str(row.failed or "")]))
    notes = (*copies_note(rows), *unanswered_note(rows), *earlier_note(rows))
    return "\n".join(lines) + "\n" + "".join(f"\n{note}\n" for note in notes)


def distinct(results: Iterable[MatchResult]) -> int | None:
    """How many different episodes were played; None when an earlier version wrote a result, without its hash.

    A match that failed before it began counts as one of its own.
    """
    episodes = {_episode(result): result for result in results}
    known = all(one.play_hash or one.ending == "failed" for one in episodes.values())
    return len(episodes) if known else None


def count_text(results: Sequence[MatchResult]) -> str:
    """4, or `4 (1 distinct)` when some episodes are copies of others."""
    found = distinct(results)
    return str(len(results)) if found in (None, len(results)) else f"{len(results)} ({found} distinct)"


def copies_note(rows: Iterable[ResultRow]) -> list[str]:
    """A sentence when a row counts an episode more than once, else nothing."""
    return [COPIES] if any(row.distinct not in (None, len(row.results)) for row in rows) else []


def unanswered_note(rows: Iterable[ResultRow]) -> list[str]:
    """Sentences when a row counts matches in which a language model did not answer, or may not have; else nothing."""
    results = [result for row in rows for result in row.results]
    found = unanswered(results)
    counted = [UNANSWERED.format(**found._asdict())] if found else []
    return [*counted, UNCOUNTED] if have_uncounted_questions(results) else counted


def are_of_before(results: Iterable[MatchResult]) -> bool:
    """Whether an earlier version wrote some, without what tells copies, or AC of the code."""
    return any(one.ending != "failed" and _is_of_before(one) for one in results)


def _is_of_before(result: MatchResult) -> bool:
    lacks_ac = result.metrics.ac is not None and result.official_ac is None
    return not result.play_hash or lacks_ac


def earlier_note(rows: Iterable[ResultRow]) -> list[str]:
    """A sentence when a row counts matches of earlier versions, else nothing."""
    return [EARLIER] if any(are_of_before(row.results) for row in rows) else []


def of_matches(results: Iterable[MatchResult], measure: Measure) -> tuple[Estimate | None, int | None]:
    """A measure over the results that have it, and how many different episodes those are; None if unknown."""
    valued = [(result, value) for result in results if (value := measure.value(result)) is not None]
    found = estimate_of_copies([(_episode(result), value) for result, value in valued])
    return found, distinct(result for result, _ in valued) if valued else None


def estimate_of(results: Iterable[MatchResult], measure: Measure) -> Estimate | None:
    """A measure over the results that have it; copies of an episode do not make its error smaller."""
    return of_matches(results, measure)[0]


def estimate_json(found: Estimate | None) -> dict[str, Any]:
    """The fields mean, stderr and n; n is 0 where nothing was measured."""
    return {"mean": None, "stderr": None, "n": 0} if found is None else found._asdict()


def _episode(result: MatchResult) -> str:
    """What copies of an episode share."""
    return result.play_hash or result.match.id


def markdown_line(cells: Sequence[str]) -> str:
    """A line of a table in Markdown."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
