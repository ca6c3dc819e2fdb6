"""The parts of BASS: measured as they play, beside the figures of the right challenge."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench import bass
from bench.bass import Numbers, _poses, bass_agent_of, main, measure
from bench.results import bass_tables
from bench.results.bass_tables import BASS, GRU, ORACLE, RANDOM, role, tables
from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import OracleBassAgent
from movingout.agents.bass.score_functions import ScoreFunction
from movingout.agents.bass.selection import Choice, choose
from movingout.agents.bass.state_vector import HELD_START, moving
from movingout.agents.checkpoint.checkpoint import DynamicsSpec
from movingout.maps import load_map
from movingout.world import World
from movingout.world.state import Floats
from tests.agents.learning import recorded, walked

SHORT = walked("SingleRotation", ticks=30)


@pytest.mark.parametrize("agent_id", ["bass@all", "bass@all:score=nfd,sampling=4x4", "bass@all:sampling=2x2"])
def test_as_many_candidates_are_drawn_as_the_agent_chooses_among(agent_id: str) -> None:
    agent = bass_agent_of(agent_id)
    numbers = measure(agent, [SHORT], moments=2, seed=0)
    assert numbers.n == 2 and numbers.selection_chance == 1 / agent.selection.own
    assert 0 < numbers.poses_l2 < numbers.next_state_l2 < numbers.random_state_l2


def test_the_partner_is_predicted_by_what_the_agent_guesses(monkeypatch: pytest.MonkeyPatch) -> None:
    agent = bass_agent_of("bass@all")
    trajectory = walked("SingleRotation", ticks=agent.selection.depth + 1)  # its only moment is the first one
    distance, heading, _ = trajectory.actions[0, 1]
    truth = np.array([distance, np.cos(heading), np.sin(heading), 1.0, -1.0], dtype=np.float32)
    monkeypatch.setattr(agent, "guesses", lambda partner: np.broadcast_to(truth, partner.shape))
    assert measure(agent, [trajectory], moments=1, seed=0).partner_10 == 1.0


@pytest.mark.parametrize(("option", "same"), [("", True), (",partner=random", False)])
def test_the_engine_is_given_the_policys_guesses_also_where_the_agent_guesses_at_random(
    option: str, same: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Floats] = []

    def choosing(score_function: ScoreFunction, seat: int, own: Floats, partner: Floats, *how: Any) -> Choice:
        seen.append(partner)
        return choose(score_function, seat, own, partner, *how)

    monkeypatch.setattr(bass, "choose", choosing)
    measure(bass.bass_agent_of(f"bass@all:score=nfd,sampling=4x4{option}"), [SHORT], moments=1, seed=0)
    by_simulator, by_engine = seen
    assert np.array_equal(by_simulator, by_engine) == same


def test_a_policy_without_noise_is_measured_with_candidates_that_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    agent = bass.bass_agent_of("bass@all")
    noise = np.zeros((4, 1, agent.spec.horizon, 5), dtype=np.float32)
    monkeypatch.setattr(agent.network, "noise_rows", 0)
    monkeypatch.setattr(agent.network, "run", lambda seen, _: noise[: len(seen), 0] + 0.5)
    agent.reset(EpisodeInfo(SHORT.map, 0, 0, SHORT.ticks))
    samples = bass._samples(agent, SHORT, bass._state(SHORT, 3), 0, 4)
    assert len(np.unique(samples[:, 0, 0])) == 4


def test_the_engine_as_simulator_makes_no_error() -> None:
    agent = bass_agent_of("bass@all:simulator=oracle")
    assert isinstance(agent, OracleBassAgent)
    numbers = measure(agent, [SHORT], moments=2, seed=0)
    assert (numbers.next_state_l2, numbers.poses_l2, numbers.selection) == (0.0, 0.0, 1.0)


def test_hands_that_change_are_counted_in_every_tick() -> None:
    trajectories = [walked("DistancePriority", ticks=120, seed=seed) for seed in (1, 2, 3)]
    changes = sum(int((trajectory.held[1:] != trajectory.held[:-1]).sum()) for trajectory in trajectories)
    assert changes > 1
    engine = bass_agent_of("bass@all:simulator=oracle")
    assert measure(engine, trajectories, moments=1, seed=0).hands == 1.0
    blind = bass_agent_of("bass@all")
    blind.simulator = lambda state: lambda joint: np.tile(moving(state), (len(joint), 8, 1))  # type: ignore[method-assign]
    assert measure(blind, trajectories, moments=1, seed=0).hands == 0.0


def test_poses_alone_know_nothing_of_hands_and_speeds() -> None:
    the_map = load_map("SingleRotation")
    row = moving(World(the_map).state())
    other = row.copy()
    other[HELD_START : HELD_START + 8] = np.eye(8)[0]
    other[4:7] = 1.0
    assert np.array_equal(_poses(row, 1), _poses(other, 1)) and _poses(row, 1).shape == (3, 4)


def test_the_paper_s_rows_hold_its_figures_for_the_challenge_and_ours_where_the_agent_is_that() -> None:
    numbers = dict.fromkeys(Numbers.__slots__, 0.5)
    rows = tables({"b": numbers, "r": numbers}, {"b": BASS, "r": RANDOM}, 2).splitlines()
    assert "| Challenge 2 | paper | b | r |" in rows
    assert "| BASS | 0.0028 | 0.5000 | 0.5000 |" in rows
    assert "| BASS | 0.4870 | 0.5000 |  |" in rows
    assert "| BASS (Random partner action) | 0.2484 |  | 0.5000 |" in rows
    assert "| BASS (qVAE) | 0.2722 |  |  |" in rows


def test_agents_are_called_what_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    ids = ["bass@all:lag=0", "bass@all:partner=random", "bass@all:simulator=oracle"]
    agents = {agent_id: bass.bass_agent_of(agent_id) for agent_id in ids}
    assert [role(*each) for each in agents.items()] == [BASS, RANDOM, ORACLE]
    card = SimpleNamespace(dynamics=DynamicsSpec(kind="gru"))
    monkeypatch.setattr(bass_tables, "find_checkpoint", lambda *_: SimpleNamespace(card=card))
    assert role(ids[0], agents[ids[0]]) == GRU


def test_the_command_prints_a_column_for_each_agent(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path, "one", ticks=20)
    command = ["--data", str(tmp_path), "--moments", "1", "--agents", "bass@all", "bass@all:score=nfd,sampling=4x4"]
    main(command)
    shown = capsys.readouterr().out
    assert "| Challenge 1 | paper | bass@all | bass@all:score=nfd,sampling=4x4 |" in shown
    assert "| BASS (GRU) | 0.2487 |  |  |" in shown and "| moments |  | 1 | 1 |" in shown
    main([*command, "--json"])
    assert set(json.loads(capsys.readouterr().out)["agents"]) == set(command[-2:])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--agents", "bass@nowhere"], "no checkpoint"),
        (["--agents", "dp@all"], "dp@all is not a BASS agent"),
        (["--agents", "bass@all:sampling=9"], "sampling is one of"),
        (["--moments", "0"], "--moments, --ticks and --workers must be at least 1"),
        (["--seed", "-1"], "--seed at least 0"),
        (["--data", "nowhere"], "there is no recording at nowhere"),
        (["--challenge", "2"], "a recording has HandOff as designed, which is not Challenge 2"),
    ],
)
def test_what_cannot_be_measured_is_refused_in_a_sentence(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "one", ticks=9)
    with pytest.raises(SystemExit) as ended:
        main(["--data", str(tmp_path), *words])
    assert ended.value.code == 2 and said in capsys.readouterr().err
