"""The bench of learned agents: fair pairings, honest errors."""

from pathlib import Path

import pytest

from bench import learning
from bench.learning import play_all, runs, table
from bench.results.episode_log import EpisodeLog, Outcome, Run
from bench.train_agents import scores
from movingout.matches import MatchError
from tests.matches.support import HERE


def _outcome(agent: str, tcr: float, the_map: str = "HandOff") -> Outcome:
    return Outcome(Run(agent, "idle", the_map, 0, 0, 10), tcr, tcr / 2, 1.0, None, 0.1)


def test_every_agent_meets_the_same_partners_in_the_same_seats() -> None:
    made = runs(["dp@all", "idle"], ["c1", "c2", "c3"], ["HandOff", "LeftRight"], episodes=4, ticks=50)
    pairings = [[(r.partner, r.map, r.seat, r.seed) for r in made if r.agent == agent] for agent in ("dp@all", "idle")]
    assert pairings[0] == pairings[1] and len(pairings[0]) == 8
    assert {seat for _, _, seat, _ in pairings[0]} == {0, 1}


def test_fewer_episodes_are_the_first_of_more() -> None:
    few, more = (runs(["idle"], ["c1", "c2", "c3"], ["HandOff", "LeftRight"], n, ticks=50) for n in (2, 5))
    assert more[: len(few)] == few


def test_every_second_partner_is_not_tied_to_a_seat() -> None:
    people = [f"c{number}" for number in range(20)]
    made = runs(["dp@all"], people, ["HandOff", "LeftRight"], episodes=4, ticks=50)
    assert {(int(run.partner[1:]) % 2, run.seat) for run in made} == {(0, 0), (0, 1), (1, 0), (1, 1)}


def test_the_table_and_the_cards_scores_come_from_the_same_outcomes() -> None:
    outcomes = [_outcome("dp@all", 0.25), _outcome("dp@all", 0.75), _outcome("idle", 0.0)]
    rows = table(outcomes, ["dp@all", "nobody", "idle"], ["HandOff"]).splitlines()
    assert len(rows) == 4 and "| idle |" in rows[3]
    assert rows[2].startswith("| dp@all | 0.500 ± 0.250 | 0.250 ± 0.125 |") and rows[2].endswith("| 2 | 0.50 |")
    assert " | – | 2 | " in rows[2]  # nobody carried together, so nobody's pulling was consistent
    card = scores(outcomes, "dp@all")["TCR with unseen scripted people"]
    assert (card.mean, card.stderr, card.n) == (0.5, 0.25, 2)


@pytest.mark.slow
def test_a_lost_match_is_no_score(tmp_path: Path) -> None:
    log, runs = tmp_path / "log.jsonl", [Run(who, "idle", "HandOff", 0, 1, 6) for who in ("idle", f"{HERE}:Crashing")]
    with pytest.raises(
        MatchError, match=r"1 of 2 matches failed: .*Crashing with idle on HandOff, seed 1: lost its worker"
    ):
        play_all(runs, 1, log)
    assert len(EpisodeLog(log).known(runs)) == 1


def test_who_sits_in_seat_0_is_blue() -> None:
    matches = [Run("dp@all", "idle", "HandOff", seat, 1, 3).match for seat in (0, 1)]
    assert [match.seats for match in matches] == [("dp@all", "idle"), ("idle", "dp@all")]


def test_an_episode_of_two_idle_agents_delivers_nothing() -> None:
    (outcome,) = play_all([Run("idle", "idle", "SingleRotation", 0, 1, 5)], 1)
    assert (outcome.tcr, outcome.nfd, outcome.ac) == (0.0, 0.0, None)


@pytest.mark.slow
def test_agents_whose_ids_have_commas_are_played(capsys: pytest.CaptureFixture[str]) -> None:
    agents = ["bass@all:score=nfd,sampling=4x4", "idle"]
    words = ["--agents", *agents, "--partners", "idle", "--maps", "SingleRotation", "--episodes", "1"]
    learning.main([*words, "--ticks", "2", "--workers", "1"])
    rows = capsys.readouterr().out.splitlines()
    assert [row.split(" | ")[0] for row in rows[2:]] == [f"| {agent}" for agent in agents]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--agents", "dp@all,bass@all"], "dp@all,bass@all"),
        (["--agents", "scriptet"], "unknown agent 'scriptet'"),
        (["--partners", "D"], "unknown agent 'D'"),
        (["--maps", "HandOf"], "unknown map 'HandOf'"),
        (["--episodes", "0"], "--episodes and --ticks must be at least 1"),
        (["--workers", "0"], "--workers must be at least 1, not 0"),
    ],
)
def test_what_cannot_be_played_is_refused_in_a_sentence(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        learning.main(words)
    assert ended.value.code == 2 and said in capsys.readouterr().err
