import pytest

from bench.memory import sizes


@pytest.mark.slow
def test_matches_that_are_over_leave_nothing_in_memory() -> None:
    """A leak of 1 KB per match, a sixth of one that was found, would add 2.4 MB between the readings."""
    early, late = (megabytes for _, megabytes in sizes(matches=5_000, every=2_500))
    assert late - early < 1.5
