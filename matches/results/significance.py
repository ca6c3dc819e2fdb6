"""Whether two means differ: Welch's test, Holm's correction, the usual marks. Copies of an episode prove nothing."""

import math
from collections.abc import Iterable, Sequence

from movingout.matches.match import MatchResult
from movingout.matches.results.table import Measure, of_matches
from movingout.world.estimates import Estimate


def evidence(results: Iterable[MatchResult], measure: Measure) -> Estimate | None:
    """The mean of a measure as a test takes it: n and the standard error are those of the different episodes.

    Ten copies of an episode are one observation; a single one has no standard error.
    """
    found, episodes = of_matches(results, measure)
    return found if found is None or episodes is None else found._replace(n=episodes)


def welch(one: Estimate | None, other: Estimate | None) -> float | None:
    """Two-sided p of Welch's test that two means are equal.

    None where one has no standard error, and where both are 0: a test says nothing without any spread.

    The tail of Student's t is computed as the regularised incomplete beta function I_x(v/2, 1/2), x = v / (v + t^2).
    """
    if one is None or other is None or one.stderr is None or other.stderr is None:
        return None
    spread = one.stderr**2 + other.stderr**2
    if spread == 0.0:
        return None
    t_squared = (one.mean - other.mean) ** 2 / spread
    freedom = spread**2 / (one.stderr**4 / (one.n - 1) + other.stderr**4 / (other.n - 1))
    return _beta_tail(freedom / (freedom + t_squared), freedom / 2.0, 0.5)


def holm(values: Sequence[float | None]) -> list[float | None]:
    """p values with Holm's correction for the number of tests; None stays None."""
    order = sorted((value, index) for index, value in enumerate(values) if value is not None)
    corrected: list[float | None] = [None] * len(values)
    worst = 0.0
    for rank, (value, index) in enumerate(order):
        worst = max(worst, min(1.0, value * (len(order) - rank)))
        corrected[index] = worst
    return corrected


def stars(p: float | None) -> str:
    """The usual marks: *** below 0.001, ** below 0.01, * below 0.05."""
    return "" if p is None else "***" if p < 0.001 else "**" if p < 0.01 else "*" if p < 0.05 else ""


def _beta_tail(x: float, a: float, b: float) -> float:
    """I_x(a, b) by the continued fraction (Lentz); Numerical Recipes, section "Incomplete Beta Function"."""
    if x <= 0.0 or x >= 1.0:
        return 0.0 if x <= 0.0 else 1.0
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x))
    if x >= (a + 1.0) / (a + b + 2.0):
        return 1.0 - front * _fraction(1.0 - x, b, a) / b
    return front * _fraction(x, a, b) / a


def _fraction(x: float, a: float, b: float) -> float:
    tiny = 1e-300
    c, d = 1.0, 1.0 / _away_from_zero(1.0 - (a + b) * x / (a + 1.0), tiny)
    value = d
    for m in range(1, 300):
        for step in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1.0 / _away_from_zero(1.0 + step * d, tiny)
            c = _away_from_zero(1.0 + step / c, tiny)
            value *= d * c
        if abs(d * c - 1.0) < 1e-14:
            break
    return value


def _away_from_zero(value: float, tiny: float) -> float:
    return value if abs(value) > tiny else tiny
