"""Mean ± standard error of the mean: the one definition that every report, table and benchmark uses."""

import math
from collections.abc import Sequence
from typing import NamedTuple


class Estimate(NamedTuple):
    """A mean of n values with its standard error, which a single value does not have."""

    mean: float
    stderr: float | None
    n: int


def estimate(values: Sequence[float]) -> Estimate | None:
    """Mean and s / sqrt(n), where s is the sample standard deviation (n - 1). None without values.

    Sums are exactly rounded, so the result does not depend on the order of the values.
    """
    n = len(values)
    if n == 0:
        return None
    mean = math.fsum(values) / n
    if n == 1:
        return Estimate(mean, None, 1)
    variance = math.fsum((value - mean) ** 2 for value in values) / (n - 1)
    return Estimate(mean, math.sqrt(variance / n), n)


def estimate_of_copies(values: Sequence[tuple[str, float]]) -> Estimate | None:
    """`estimate` of (episode, value) where values of the same episode are copies: it counts each episode once.

    Copies, as agents without chance play them with every seed, weigh in the mean as often as they were played, so
    that every map weighs alike. The standard error takes them together: sqrt(G / (G - 1) sum over the G different
    episodes of (sum of deviations)^2) / n, which is s / sqrt(n) where none is a copy. So it holds, too, where
    values of an episode are not copies but alike, as moments of one are.
    """
    found = estimate([value for _, value in values])
    count = len({episode for episode, _ in values})
    if found is None or count == found.n:
        return found
    if count == 1:
        return found._replace(stderr=None)
    deviations: dict[str, list[float]] = {}
    for episode, value in values:
        deviations.setdefault(episode, []).append(value - found.mean)
    squares = math.fsum(math.fsum(alike) ** 2 for alike in deviations.values())
    return found._replace(stderr=math.sqrt(squares * count / (count - 1)) / found.n)


def estimate_text(found: Estimate | None) -> str:
    """0.512 ± 0.031, without the error where there is none, and a dash where nothing was measured."""
    return _text(found, "")


def difference_text(found: Estimate | None) -> str:
    """The same of a difference, which has a sign: +0.512 ± 0.031."""
    return _text(found, "+")


def _text(found: Estimate | None, sign: str) -> str:
    if found is None:
        return "–"
    return f"{found.mean:{sign}.3f}" + ("" if found.stderr is None else f" ± {found.stderr:.3f}")
