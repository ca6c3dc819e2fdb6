"""The statistics against published examples."""

from itertools import product

import numpy as np
import pytest
from scipy import stats

from movingout.study.analysis.comparisons import PartnerComparison, compare, corrected, signed_rank, trend

# Student's sleep data (1908): extra hours of sleep of ten patients under two drugs.
FIRST = dict(zip("abcdefghij", (0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0), strict=True))
SECOND = dict(zip("abcdefghij", (1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4), strict=True))


def comparison(**changes: object) -> PartnerComparison:
    values: dict[str, object] = {
        "measure": "m", "one": "a", "other": "b", "n": (2, 2), "pairs": 2, "difference": 0.0,
        "t": None, "t_p": None, "w_p": None, "holm_p": None, "g": None, "g_interval": None,
    }  # fmt: skip
    return PartnerComparison(**(values | changes))  # type: ignore[arg-type]


def test_the_independent_t_test_is_that_of_students_sleep_data() -> None:
    found = compare("sleep", "one", "two", FIRST, SECOND)
    assert found is not None
    assert found.t == pytest.approx(-1.8608, abs=1e-4)
    assert found.t_p == pytest.approx(0.07919, abs=1e-5)
    assert found.difference == pytest.approx(-1.58) and (found.n, found.pairs) == ((10, 10), 10)


def test_the_signed_rank_test_is_that_of_hollander_and_wolfe() -> None:
    """Depression scale of nine patients at two visits; R's help page of wilcox.test: two-sided p = 0.03906."""
    before = (1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30)
    after = (0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29)
    assert signed_rank([x - y for x, y in zip(before, after, strict=True)]) == pytest.approx(0.03906, abs=1e-5)


@pytest.mark.parametrize(
    ("differences", "p"),
    [
        ([1, 1, 1, 1], 2 / 16),
        ([2, 1, 3, 0], 2 / 8),  # three are left, and none is against
        (
            [1, -1, 2, 3, 3, 0],
            6 / 32,
        ),  # ranks 1.5, 1.5, 3, 4.5, 4.5; a sum of at most 1.5 has none, or one of the first two
        ([1, -1], 1.0),
    ],
)
def test_ties_and_zeros_are_exact_where_people_are_few(differences: list[float], p: float) -> None:
    """By counting the signs, as R's coin::wilcoxsign_test does (distribution = "exact", zero.method = "Wilcoxon")."""
    assert signed_rank(differences) == pytest.approx(p, abs=1e-12)


def test_the_exact_p_is_that_of_all_signs_counted_one_by_one() -> None:
    differences = [1.0, 1.0, -2.0, 2.0, 2.0, 3.0, -1.0, 4.0, 5.0]
    ranks = stats.rankdata(np.abs(differences))
    sums = [sum(rank for rank, sign in zip(ranks, signs, strict=True) if sign) for signs in product((0, 1), repeat=9)]
    against = ranks[2] + ranks[6]
    assert signed_rank(differences) == pytest.approx(2 * sum(one <= against for one in sums) / 2**9)


def test_many_tied_differences_are_tested_by_the_normal_approximation_corrected_for_ties() -> None:
    """60 differences of one size, 36 up: z = (36 - 30) * 30.5 / sqrt(60 * 30.5**2 / 4) = 12 / sqrt(60)."""
    assert signed_rank([1.0] * 36 + [-1.0] * 24) == pytest.approx(0.12134, abs=1e-4)


def test_equal_differences_of_means_are_ties_whatever_their_last_digits() -> None:
    """Twelve people rate three rounds with each partner: +1/3 nine times and -1/3 three times; twelve ties."""
    ratings = [(1, 2, 2), (2, 3, 3), (3, 3, 4), (4, 4, 5), (5, 5, 6), (5, 6, 6), (2, 2, 3), (6, 6, 7), (1, 1, 2)]
    means = [sum(map(float, one)) / 3 for one in ratings]
    differences = [mean - (sum(one) - 1) / 3 for mean, one in zip(means, ratings, strict=True)]
    differences += [(sum(one) - 1) / 3 - mean for mean, one in zip(means[:3], ratings[:3], strict=True)]
    assert len({abs(one) for one in differences}) > 1, "in floats they differ"
    assert signed_rank(differences) == pytest.approx(signed_rank([1.0] * 9 + [-1.0] * 3), abs=1e-12)
    orders = [sum(values) / 3 - sum(reversed(values)) / 3 for values in [(0.1, 0.2, 0.3)] * 6]
    assert any(orders) and signed_rank(orders) is None, "the same values in another order"


def test_the_effect_size_is_that_of_borenstein() -> None:
    """Introduction to Meta-Analysis (2009), chapter 4: means 103 and 100, spreads 5.5 and 4.5, 50 each: g = 0.5924.

    The interval is g +- 1.96 sqrt(2 / 50 + g^2 / (2 (100 - 3.94))), by hand.
    """
    found = compare("score", "one", "two", spread(103, 5.5), spread(100, 4.5))
    assert found is not None and found.g_interval is not None
    assert found.g == pytest.approx(0.5924, abs=2e-4)
    assert found.g_interval[0] == pytest.approx(0.1916, abs=3e-4)
    assert found.g_interval[1] == pytest.approx(0.9932, abs=3e-4)


def spread(mean: float, deviation: float) -> dict[str, float]:
    """Fifty values with exactly this mean and sample deviation."""
    half = deviation * (49 / 50) ** 0.5
    return {str(number): mean + (half if number % 2 else -half) for number in range(50)}


def test_holms_correction_is_that_of_rs_p_adjust() -> None:
    found = corrected([comparison(w_p=p) for p in (0.01, 0.02, None, 0.03, 0.04, 0.05)])
    assert [one.holm_p for one in found] == [pytest.approx(p) if p else None for p in (0.05, 0.08, 0, 0.09, 0.09, 0.09)]


def test_what_cannot_be_tested_has_no_p() -> None:
    assert signed_rank([0.0, 0.0]) is None and signed_rank([]) is None
    assert compare("m", "a", "b", {}, {"x": 1.0}) is None
    same = compare("m", "a", "b", {"x": 1.0, "y": 1.0}, {"x": 1.0, "y": 1.0})
    assert same is not None and (same.t, same.w_p, same.g) == (None, None, None)


def test_a_trend_is_the_mean_rank_correlation_with_the_position() -> None:
    found = trend([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0], [1.0, 2.0, 3.0], [5.0, 5.0, 5.0], [1.0]])
    assert found is not None and found.rho == pytest.approx(1 / 3) and found.used == 3, "two have no trend"
    assert trend([[1.0, 1.0, 1.0]]) is None


def test_values_that_hardly_differ_are_not_tested_and_one_constant_partner_is() -> None:
    same = {"a": 0.1 + 0.2, "b": 0.3, "c": 0.3}
    found = compare("tcr", "x", "y", same, same)
    assert found is not None and (found.t, found.t_p, found.g) == (None, None, None)
    other = compare("tcr", "x", "y", {"a": 0.5, "b": 0.5, "c": 0.5}, {"a": 0.1, "b": 0.2, "c": 0.3})
    assert other is not None and other.t == pytest.approx(3 * 3**0.5)  # 0.3 / sqrt((0.01 + 0) / 2 * 2 / 3)
