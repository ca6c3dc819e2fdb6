"""How long steps take is estimated for what the budget really trains."""

from dataclasses import replace

import pytest

from movingout.matches.match import Match
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.costs import match_seconds, training_seconds
from movingout.matches.paper.methods import METHODS

SMALL, PAPER_SIZE, FULL = (BUDGETS[name] for name in ("small", "paper-size", "full"))


@pytest.mark.parametrize("kind", ["mlp", "gru", "dp"])
def test_the_papers_networks_cost_more_than_small_ones_and_twice_the_updates_twice_as_much(kind: str) -> None:
    method = METHODS[kind]
    assert training_seconds(method, PAPER_SIZE) > 2 * training_seconds(method, SMALL)
    words = PAPER_SIZE.options[kind]
    there = words.index("--updates") + 1
    twice = replace(PAPER_SIZE, options={kind: (*words[:there], 2 * words[there], *words[there + 1 :])})
    start = 4.0
    assert training_seconds(method, twice) - start == pytest.approx(2 * (training_seconds(method, PAPER_SIZE) - start))


def test_an_agent_of_a_single_map_has_a_quarter_of_the_updates() -> None:
    start, one, all_maps = 4.0, METHODS["dp-noise-0.02"], METHODS["dp"]
    for budget in (SMALL, PAPER_SIZE):
        assert training_seconds(all_maps, budget) - start == pytest.approx(4 * (training_seconds(one, budget) - start))


def test_only_full_takes_the_times_of_the_papers_card() -> None:
    assert training_seconds(METHODS["dp"], FULL) == 7200.0
    assert [name for name, budget in BUDGETS.items() if budget.gpu] == ["full"]
    match = Match("HandOff", "dp@c1", "dp@c1", 0)
    assert match_seconds(match, SMALL) < min(match_seconds(match, PAPER_SIZE), match_seconds(match, FULL))
    with_bass = Match("HandOff", "bass@c1", "dp@c1", 0)
    assert match_seconds(with_bass, FULL) < match_seconds(with_bass, PAPER_SIZE)
