"""Tables of matches: copies of an episode are counted once in every error."""

from dataclasses import replace

import pytest

from movingout.matches.match import Match, MatchResult
from movingout.matches.results.significance import evidence
from movingout.matches.results.table import EARLIER, MEASURES, ResultRow, markdown, of_matches
from movingout.matches.results.unanswered import UNCOUNTED, unanswered
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


def test_a_table_says_where_language_models_did_not_answer() -> None:
    counts = [{"red_llm_questions": 9, "red_llm_useful": 9}, {"blue_llm_questions": 5, "blue_llm_useful": 2}, {}]
    results = [replace(_result(seed, 0.5, f"h{seed}"), counts=one) for seed, one in enumerate(counts)]
    row = ResultRow("all", 1, "a", "b", "HandOff", tuple(results))
    said = "Language models gave no usable answer to 3 of 14 questions, in 1 of 2 matches; meanwhile"
    assert said in markdown([row, row]) and "Language models" not in markdown([replace(row, results=(results[0],))])
    assert unanswered([results[0], results[2]]) is None
    own = {"red_questions": 4, "blue_open_questions": 3, "blue_open_llm_questions": 3}  # of agents that ask no model
    assert unanswered([replace(results[1], counts=own)]) is None


@pytest.mark.parametrize("agent_id", ["llm:model=m,url=http://localhost,wait=yes", "late:agent=llm:model=m;wait=yes"])
def test_a_table_says_that_before_nobody_counted_what_language_models_answered(agent_id: str) -> None:
    """Where no server answered, the scores of the fallback counted as the model's."""
    before = _result(0, 0.5, "h")
    before = replace(before, match=replace(before.match, red=agent_id))
    row = ResultRow("all", 1, "a", "b", "HandOff", (before,))
    said = markdown([row])
    assert UNCOUNTED in said and EARLIER not in said, "it lacks nothing else"
    assert EARLIER in (said := markdown([replace(row, results=(_result(0, 0.5),))])) and UNCOUNTED not in said
    for now in (
        replace(before, counts={"red_llm_questions": 0}),
        replace(before, ending="failed"),
        _result(0, 0.5, "h"),
    ):
        assert "earlier version" not in markdown([replace(row, results=(now,))])


def test_the_error_in_a_table_is_the_one_that_its_p_value_takes() -> None:
    copies = tuple(_result(seed, float(seed % 2), f"h{seed % 2}") for seed in range(8))
    shown = ResultRow("all", 1, "a", "b", "HandOff", copies).estimate(TCR)
    taken = evidence(copies, TCR)
    assert shown is not None and taken is not None
    assert shown == pytest.approx((0.5, 0.5, 8))
    assert taken == shown._replace(n=2)
