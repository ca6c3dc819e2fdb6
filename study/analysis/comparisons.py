"""Comparisons of two partners, by scipy and statsmodels alone.

The paper compared models by independent t-tests. Its participants met several models, so their answers belong
together, and Likert answers are ranks: `signed_rank` (Wilcoxon, paired) with Holm's correction over all comparisons
of a table is the better choice, and both are shown.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import stats
from statsmodels.stats.meta_analysis import effectsize_smd
from statsmodels.stats.multitest import multipletests

CONFIDENCE = 0.95
_DECIMALS = 10  # of differences that are ranked
_MOST_EXACT = 50  # of them, for an exact p
ROUNDING = 1e-12  # a smaller difference, as a share of the values, is none
_Z = float(stats.norm.ppf(0.5 + CONFIDENCE / 2))


@dataclass(frozen=True, slots=True)
class PartnerComparison:
    """`one` against `other` in one measure, over participants."""

    measure: str
    one: str
    other: str
    n: tuple[int, int]  # participants of each
    pairs: int  # participants who met both
    difference: float  # of the means
    t: float | None  # independent t-test with equal variances, as in the paper
    t_p: float | None
    w_p: float | None  # Wilcoxon's signed-rank test over the pairs
    holm_p: float | None  # w_p corrected over the comparisons of the table
    g: float | None  # Hedges' g, the standardised difference corrected for few participants
    g_interval: tuple[float, float] | None  # 95 %


def compare(
    measure: str, one: str, other: str, first: dict[str, float], second: dict[str, float]
) -> PartnerComparison | None:
    """Two partners in one measure; the values are means per participant. None where one of them has no value."""
    a, b = list(first.values()), list(second.values())
    if not a or not b:
        return None
    both = [pid for pid in first if pid in second]
    t, t_p = _independent(a, b)
    g, interval = _effect(a, b)
    return PartnerComparison(
        measure=measure,
        one=one,
        other=other,
        n=(len(a), len(b)),
        pairs=len(both),
        difference=float(np.mean(a) - np.mean(b)),
        t=t,
        t_p=t_p,
        w_p=signed_rank([first[pid] - second[pid] for pid in both]),
        holm_p=None,
        g=g,
        g_interval=interval,
    )


def corrected(comparisons: Sequence[PartnerComparison]) -> list[PartnerComparison]:
    """With Holm's correction over those that were tested."""
    tested = [index for index, one in enumerate(comparisons) if one.w_p is not None]
    result = list(comparisons)
    if tested:
        adjusted = multipletests([comparisons[index].w_p for index in tested], method="holm")[1]
        for index, p in zip(tested, adjusted, strict=True):
            result[index] = replace(result[index], holm_p=float(p))
    return result


def signed_rank(differences: Sequence[float]) -> float | None:
    """p of Wilcoxon's signed-rank test, two-sided; None where no difference is left to rank.

    Differences of none are left out (Wilcoxon's own rule). Up to 50 differences the p is exact, over all signs that the
    ranks could have had, also where ranks tie; beyond that it is the normal approximation corrected for ties.
    Means of several values differ in their last digits though they are equal, which would break ties: so differences
    are rounded first.
    """
    ranked = [value for value in (round(value, _DECIMALS) for value in differences) if value]
    if not ranked:
        return None
    if len(ranked) > _MOST_EXACT:
        return float(stats.wilcoxon(ranked, method="asymptotic").pvalue)
    return _exact_p(ranked)


def _exact_p(ranked: Sequence[float]) -> float:
    """The share of all signs of these ranks whose sum is at least as far from the middle."""
    ranks = np.rint(2 * stats.rankdata(np.abs(ranked))).astype(int)  # doubled: tied ranks end in a half
    ways = np.ones(1)  # how many signs lead to each sum of the positive ranks
    for rank in ranks:
        ways = np.pad(ways, (0, rank)) + np.pad(ways, (rank, 0))
    positive = int(ranks[np.asarray(ranked) > 0].sum())
    tail = min(ways[: positive + 1].sum(), ways[positive:].sum())
    return min(1.0, 2 * float(tail / ways.sum()))


class Trend(NamedTuple):
    """Whether values rise with their place."""

    rho: float  # the mean of Spearman's per participant
    p: float | None  # that it is not zero
    used: int  # participants with at least three values that are not all the same: the others have no rho


def trend(series: Sequence[Sequence[float]]) -> Trend | None:
    """The trend of a series per participant; None where nobody has one."""
    rhos = [
        float(stats.spearmanr(range(len(values)), values).statistic)
        for values in series
        if len(values) > 2 and len(set(values)) > 1
    ]
    return Trend(float(np.mean(rhos)), signed_rank(rhos), len(rhos)) if rhos else None


def _independent(a: Sequence[float], b: Sequence[float]) -> tuple[float | None, float | None]:
    if min(len(a), len(b)) < 2 or not _varies(a, b):
        return None, None
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", "Precision loss"
        )  # one of the two may be constant: the pooled variance is not
        found = stats.ttest_ind(a, b)
    return float(found.statistic), float(found.pvalue)


def _effect(a: Sequence[float], b: Sequence[float]) -> tuple[float | None, tuple[float, float] | None]:
    if min(len(a), len(b)) < 2 or not _varies(a, b):
        return None, None
    spread = [float(np.std(values, ddof=1)) for values in (a, b)]
    g, variance = effectsize_smd(np.mean(a), spread[0], len(a), np.mean(b), spread[1], len(b))
    half = _Z * math.sqrt(float(variance))
    return float(g), (float(g) - half, float(g) + half)


def _varies(a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether the values of at least one differ by more than rounding."""
    return any(float(np.ptp(values)) > ROUNDING * float(np.max(np.abs(values))) for values in (a, b))
