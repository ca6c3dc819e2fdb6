"""The bench of learned agents: fair pairings, honest errors."""

import math

from bench.learning import Outcome, Run, mean_error, play, runs, table
from bench.train_agents import report, scores


def _outcome(agent: str, tcr: float, the_map: str = "HandOff") -> Outcome:
    return Outcome(Run(agent, "idle", the_map, 0, 0, 10), tcr, tcr / 2, 1.0, None, 0.1)


def test_every_agent_meets_the_same_partners_in_the_same_seats() -> None:
    made = runs(["dp@all", "idle"], ["c1", "c2", "c3"], ["HandOff", "LeftRight"], episodes=4, ticks=50)
    pairings = [[(r.partner, r.map, r.seat, r.seed) for r in made if r.agent == agent] for agent in ("dp@all", "idle")]
    assert pairings[0] == pairings[1] and len(pairings[0]) == 8
    assert {seat for _, _, seat, _ in pairings[0]} == {0, 1}


def test_errors_are_those_of_the_mean() -> None:
    mean, error = mean_error([0.0, 1.0, 0.0, 1.0])
    assert mean == 0.5 and math.isclose(error, math.sqrt(1 / 3) / 2)


def test_the_table_and_the_cards_scores_come_from_the_same_outcomes() -> None:
    outcomes = [_outcome("dp@all", 0.25), _outcome("dp@all", 0.75), _outcome("idle", 0.0)]
    rows = table(outcomes, ["dp@all", "idle"], ["HandOff"]).splitlines()
    assert rows[2].startswith("| dp@all | 0.500 ± 0.250 | 0.250 ± 0.125 |") and rows[2].endswith("| 2 | 0.50 |")
    card = scores(outcomes, "dp@all")["tcr with unseen scripted people"]
    assert (card.mean, card.stderr, card.n) == (0.5, 0.25, 2)
    assert "held-out scripted people" in report(outcomes, ["dp@all", "idle"])


def test_an_episode_of_two_idle_agents_delivers_nothing() -> None:
    outcome = play(Run("idle", "idle", "SingleRotation", 0, 1, 5))
    assert (outcome.tcr, outcome.nfd, outcome.ac) == (0.0, 0.0, None)
