"""Numbers of several matches and trainings become one, and nothing is counted twice."""

from dataclasses import replace

import pytest

from movingout.matches.match import Match, MatchResult
from movingout.matches.paper.pooling import averaged, between, of_matches, pooled
from movingout.matches.results.table import MEASURES
from movingout.world.estimates import Estimate, estimate
from movingout.world.metrics import Metrics

TCR, AC = MEASURES[0], next(measure for measure in MEASURES if measure.key == "ac")


def _result(seed: int, tcr: float, play_hash: str = "", ac: float | None = None) -> MatchResult:
    metrics = Metrics.of({"tcr": tcr, "nfd": 0.5, "wt_s": 1.5, "ac": ac})
    return replace(MatchResult(Match("HandOff", "a", "b", seed), "time", 60, 0, 4, metrics, 0.03), play_hash=play_hash)


def test_the_error_of_different_episodes_is_the_usual_one() -> None:
    values = [0.1, 0.4, 0.9, 0.2]
    found, count = of_matches([_result(k, value, f"h{k}") for k, value in enumerate(values)], TCR)
    usual = estimate(values)
    assert found is not None and usual is not None and count == 4
    assert found == pytest.approx(usual)


def test_copies_of_an_episode_do_not_make_the_error_smaller() -> None:
    once = [_result(k, value, f"h{k}") for k, value in enumerate((0.0, 0.5, 1.0))]
    often = [_result(10 * k + n, value, f"h{k}") for k, value in enumerate((0.0, 0.5, 1.0)) for n in range(20)]
    (one, _), (many, count) = of_matches(once, TCR), of_matches(often, TCR)
    assert one is not None and many is not None and count == 3
    assert (many.mean, many.n) == (one.mean, 60) and many.stderr == pytest.approx(one.stderr)
    alone, _ = of_matches(often[:20], TCR)
    assert alone is not None and alone.stderr is None, "one episode has no error, however often it is played"


def test_results_of_earlier_versions_and_those_without_the_measure() -> None:
    found, count = of_matches([_result(0, 0.0), _result(1, 1.0)], TCR)
    assert found is not None and found.stderr == pytest.approx(0.5) and count is None
    assert of_matches([_result(0, 0.0)], AC) == (None, None)
    assert of_matches([_result(0, 0.0, "x"), _result(1, 0.0, "y", 0.5)], AC) == (Estimate(0.5, None, 1), 1)


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
