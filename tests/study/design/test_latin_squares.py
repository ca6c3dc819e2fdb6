"""Williams squares and the way through several factors."""

from collections import Counter
from itertools import pairwise
from math import prod

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from movingout.study.design.latin_squares import crossed, williams


@pytest.mark.parametrize("n", range(1, 13))
def test_every_treatment_is_in_every_position_and_before_every_other_equally_often(n: int) -> None:
    rows = williams(n)
    positions = Counter((place, treatment) for row in rows for place, treatment in enumerate(row))
    followed = Counter(pair for row in rows for pair in pairwise(row))
    assert len(rows) == (n if n % 2 == 0 or n == 1 else 2 * n)
    assert all(sorted(row) == list(range(n)) for row in rows)
    assert len(positions) == n * n and len(set(positions.values())) == 1
    assert len(followed) == n * (n - 1) and len(set(followed.values())) <= 1


LEVELS = st.lists(st.integers(1, 12), min_size=1, max_size=4).filter(lambda levels: prod(levels) <= 600)


@settings(max_examples=60, deadline=None)
@given(levels=LEVELS)
def test_all_combinations_come_up_once_before_any_comes_up_twice(levels: list[int]) -> None:
    found = {crossed(slot, levels) for slot in range(prod(levels))}
    assert len(found) == prod(levels)


@settings(max_examples=60, deadline=None)
@given(levels=LEVELS, share=st.floats(0.0, 1.0))
def test_however_early_a_study_stops_the_levels_of_a_factor_differ_by_one_at_most(
    levels: list[int], share: float
) -> None:
    slots = round(share * prod(levels))
    for factor, count in enumerate(levels):
        seen = Counter(crossed(slot, levels)[factor] for slot in range(slots))
        counts = [seen[level] for level in range(count)]
        assert max(counts) - min(counts) <= 1
