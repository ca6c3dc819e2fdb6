"""Mean ± standard error."""

import math

import pytest

from movingout.world.estimates import Estimate, difference_text, estimate, estimate_of_copies, estimate_text


def test_an_estimate_is_the_mean_and_its_standard_error() -> None:
    assert estimate([1.0, 2.0, 3.0, 4.0]) == Estimate(2.5, math.sqrt((5 / 3) / 4), 4)
    assert estimate([2.0]) == Estimate(2.0, None, 1)
    assert estimate([]) is None


def test_shares_have_the_standard_error_of_a_proportion() -> None:
    found = estimate([1.0] * 3 + [0.0] * 7)
    assert found is not None and found.mean == 0.3
    assert found.stderr == pytest.approx(math.sqrt(0.3 * 0.7 / 9))


def test_the_order_of_the_values_changes_no_bit() -> None:
    values = [0.1 * k for k in range(50)] + [1e16, -1e16]
    assert estimate(values) == estimate(values[::-1])


def test_copies_weigh_in_the_mean_and_count_once_in_the_error() -> None:
    assert estimate_of_copies([("a", 0.0), ("b", 1.0), ("b", 1.0), ("a", 0.0)]) == Estimate(0.5, 0.5, 4)
    assert estimate_of_copies([("a", 0.2), ("b", 0.4), ("c", 0.9)]) == estimate([0.2, 0.4, 0.9])
    assert estimate_of_copies([("a", 0.5), ("a", 0.5)]) == Estimate(0.5, None, 2)
    assert estimate_of_copies([]) is None


def test_an_estimate_is_written_with_its_error_where_it_has_one() -> None:
    assert [estimate_text(estimate(values)) for values in ([0.25, 0.75], [0.5], [])] == ["0.500 ± 0.250", "0.500", "–"]
    assert [difference_text(estimate(values)) for values in ([0.25, 0.75], [-0.5], [])] == [
        "+0.500 ± 0.250",
        "-0.500",
        "–",
    ]
