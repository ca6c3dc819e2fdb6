"""Numbers of several trainings become one, and nothing is counted twice."""

import pytest

from movingout.matches.paper.pooling import averaged, between, of_the_same_samples, pooled
from movingout.world.estimates import Estimate, estimate


def test_parts_are_pooled_as_if_their_values_lay_together() -> None:
    parts = [0.1, 0.4, 0.9], [0.3], [0.7, 0.2]
    together = estimate([value for part in parts for value in part])
    found = [estimate(part) for part in parts]
    assert together is not None and pooled([one for one in found if one]) == pytest.approx(together)
    assert pooled([Estimate(0.5, None, 1)]) == Estimate(0.5, None, 1)


def test_the_error_between_trainings_is_of_their_means() -> None:
    parts = [Estimate(0.2, 0.001, 240), None, Estimate(0.4, 0.001, 240)]
    found = between(parts)
    assert found is not None and found.n == 2 and found.stderr == pytest.approx(0.1)
    assert between(parts[:2]) is None
    mean = averaged([Estimate(0.2, 0.3, 10), Estimate(0.4, 0.4, 10)])
    assert mean == pytest.approx(Estimate(0.3, 0.25, 20))
    assert averaged([Estimate(0.2, 0.3, 10), Estimate(0.4, None, 10)]).stderr is None


def test_trainings_that_were_measured_on_the_same_samples_do_not_make_each_other_surer() -> None:
    found = of_the_same_samples([Estimate(0.4, 0.05, 96), Estimate(0.5, 0.03, 96), Estimate(0.6, 0.04, 90)])
    assert found == pytest.approx(Estimate(0.5, 0.04, 96))
    assert of_the_same_samples([Estimate(0.4, 0.05, 96), Estimate(0.5, None, 1)]).stderr is None
