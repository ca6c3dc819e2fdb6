"""One number from several trainings: means with standard errors that count nothing twice."""

import math
from collections.abc import Iterable, Mapping, Sequence

from movingout.matches.match import MatchResult
from movingout.matches.results.table import Measure
from movingout.world.estimates import Estimate, estimate


def of_matches(results: Iterable[MatchResult], measure: Measure) -> tuple[Estimate | None, int | None]:
    """The mean over the matches that have the measure, and how many different episodes those are; None if unknown.

    Copies of an episode, as an agent without chance plays them with every seed, weigh in the mean as often as they
    were played, so that every map weighs alike. The standard error takes them together: sqrt(G / (G - 1) sum over the
    G different episodes of (sum of deviations)^2) / n, which is s / sqrt(n) where none is a copy.
    """
    valued = [(result, value) for result in results if (value := measure.value(result)) is not None]
    if not valued:
        return None, None
    n = len(valued)
    mean = math.fsum(value for _, value in valued) / n
    episodes: dict[str, list[float]] = {}
    for result, value in valued:
        episodes.setdefault(result.play_hash or result.match.id, []).append(value - mean)
    count = len(episodes)
    squares = math.fsum(math.fsum(deviations) ** 2 for deviations in episodes.values())
    error = math.sqrt(squares * count / (count - 1)) / n if count > 1 else None
    known = all(result.play_hash or result.ending == "failed" for result, _ in valued)
    return Estimate(mean, error, n), count if known else None


def pooled(parts: Sequence[Estimate]) -> Estimate:
    """What `estimate` would give for the values of all parts together."""
    n = sum(part.n for part in parts)
    mean = math.fsum(part.mean * part.n for part in parts) / n
    within = math.fsum((part.stderr or 0.0) ** 2 * part.n * (part.n - 1) for part in parts)
    apart = math.fsum(part.n * (part.mean - mean) ** 2 for part in parts)
    return Estimate(mean, math.sqrt((within + apart) / (n - 1) / n) if n > 1 else None, n)


def averaged(parts: Sequence[Estimate]) -> Estimate:
    """The mean of means that have errors of their own, as by the jackknife; without an error where one has none."""
    errors = [part.stderr for part in parts if part.stderr is not None]
    whole = len(errors) == len(parts)
    return Estimate(
        math.fsum(part.mean for part in parts) / len(parts),
        math.sqrt(math.fsum(error**2 for error in errors)) / len(parts) if whole else None,
        sum(part.n for part in parts),
    )


def between(parts: Iterable[Estimate | None]) -> Estimate | None:
    """The mean of the means of trainings, with the error between them; None for fewer than two."""
    means = [part.mean for part in parts if part is not None]
    return estimate(means) if len(means) > 1 else None


def fields(parts: Sequence[Mapping[str, Estimate]], name: str) -> list[Estimate]:
    """A field of those parts that have it."""
    return [part[name] for part in parts if name in part]
