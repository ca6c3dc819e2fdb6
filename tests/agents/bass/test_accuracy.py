"""The parts of BASS are measured as they play."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.bass import accuracy
from movingout.agents.bass.accuracy import bass_accuracy
from movingout.agents.bass.agent import BassAgent, acting
from movingout.agents.bass.engine_agent import OracleBassAgent
from movingout.agents.bass.score_functions import ScoreFunction
from movingout.agents.bass.selection import Choice, choose
from movingout.agents.bass.state_vector import HELD_START, moving
from movingout.agents.catalogue import load_agent
from movingout.maps import load_map
from movingout.world import World
from movingout.world.state import Floats
from tests.agents.learning import walked

SHORT = walked("SingleRotation", ticks=30)


def _bass_agent(agent_id: str) -> BassAgent:
    agent = load_agent(agent_id)
    assert isinstance(agent, BassAgent)
    return agent


@pytest.mark.parametrize("agent_id", ["bass@all", "bass@all:score=nfd,sampling=4x4", "bass@all:sampling=2x2"])
def test_as_many_candidates_are_drawn_as_the_agent_chooses_among(agent_id: str) -> None:
    agent = _bass_agent(agent_id)
    numbers = bass_accuracy(agent, [SHORT], moments=2, seed=0)
    assert numbers.n == 2 and numbers.selection_chance == 1 / agent.selection.own
    assert 0 < numbers.poses_l2 < numbers.next_state_l2 < numbers.random_state_l2


def test_an_agent_with_a_memory_and_a_frame_of_its_own_samples_as_in_play() -> None:
    agent = _bass_agent("bass@any")
    agent.reset(EpisodeInfo(SHORT.map, seat=0, seed=0, ticks=SHORT.ticks))
    agent.execute = 1
    for tick in range(21):
        state = accuracy._state(SHORT, tick)
        agent.random = np.random.default_rng(7)
        agent.act(Observation(state, tick, seat=0, encode=lambda layout: np.zeros(0)))
    agent.random = np.random.default_rng(7)
    sampled = accuracy._samples(agent, SHORT, state, 0, agent.selection.own)
    assert agent._plan is not None and np.isclose(sampled, agent._plan.chunk, atol=1e-4).all(axis=(1, 2)).any()
    assert bass_accuracy(agent, [SHORT], moments=4, seed=0).poses_l2 < 0.01  # it simulates with the engine


def test_the_partner_is_predicted_by_what_the_agent_guesses(monkeypatch: pytest.MonkeyPatch) -> None:
    agent = _bass_agent("bass@all")
    trajectory = walked("SingleRotation", ticks=agent.selection.depth + 1)  # its only moment is the first one
    distance, heading, _ = trajectory.actions[0, 1]
    truth = np.array([distance, np.cos(heading), np.sin(heading), 1.0, -1.0], dtype=np.float32)
    monkeypatch.setattr(agent, "guesses", lambda partner, _: np.broadcast_to(truth, partner.shape))
    assert bass_accuracy(agent, [trajectory], moments=1, seed=0).partner_10 == 1.0


@pytest.mark.parametrize(("option", "same"), [("", True), (",partner=random", False)])
def test_the_engine_is_given_the_policys_guesses_also_where_the_agent_guesses_at_random(
    option: str, same: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Floats] = []

    def choosing(score_function: ScoreFunction, seat: int, own: Floats, partner: Floats, *how: Any) -> Choice:
        seen.append(partner)
        return choose(score_function, seat, own, partner, *how)

    monkeypatch.setattr(accuracy, "choose", choosing)
    bass_accuracy(_bass_agent(f"bass@all:score=nfd,sampling=4x4{option}"), [SHORT], moments=1, seed=0)
    by_simulator, by_engine = seen
    assert np.array_equal(by_simulator, by_engine) == same


def test_a_policy_without_noise_is_measured_with_candidates_that_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    agent = _bass_agent("bass@all")
    noise = np.zeros((4, 1, agent.spec.horizon, 5), dtype=np.float32)
    monkeypatch.setattr(agent.network, "noise_rows", 0)
    monkeypatch.setattr(agent.network, "run", lambda seen, _: noise[: len(seen), 0] + 0.5)
    agent.reset(EpisodeInfo(SHORT.map, 0, 0, SHORT.ticks))
    samples = accuracy._samples(agent, SHORT, accuracy._state(SHORT, 3), 0, 4)
    assert len(np.unique(samples[:, 0, 0])) == 4


def test_the_engine_as_simulator_makes_no_error() -> None:
    agent = _bass_agent("bass@all:simulator=oracle")
    assert isinstance(agent, OracleBassAgent)
    numbers = bass_accuracy(agent, [SHORT], moments=2, seed=0)
    assert (numbers.next_state_l2, numbers.poses_l2, numbers.selection) == (0.0, 0.0, 1.0)


def test_hands_that_change_are_counted_in_every_tick() -> None:
    trajectories = [walked("DistancePriority", ticks=120, seed=seed) for seed in (1, 2, 3)]
    changes = sum(int((trajectory.held[1:] != trajectory.held[:-1]).sum()) for trajectory in trajectories)
    assert changes > 1
    engine = _bass_agent("bass@all:simulator=oracle")
    assert bass_accuracy(engine, trajectories, moments=1, seed=0).hands == 1.0
    blind = _bass_agent("bass@all")
    blind.simulator = lambda state: lambda joint: np.tile(moving(state), (len(joint), 8, 1))  # type: ignore[method-assign]
    assert bass_accuracy(blind, trajectories, moments=1, seed=0).hands == 0.0


def test_poses_alone_know_nothing_of_hands_and_speeds() -> None:
    the_map = load_map("SingleRotation")
    row = moving(World(the_map).state())
    other = row.copy()
    other[HELD_START : HELD_START + 8] = np.eye(8)[0]
    other[4:7] = 1.0
    assert np.array_equal(accuracy._poses(row, 1), accuracy._poses(other, 1)) and accuracy._poses(row, 1).shape == (
        3,
        4,
    )


@pytest.mark.parametrize(("held", "level"), [(0, 1.0), (-1, 0.0)])
def test_alone_the_partner_is_taken_to_stand_still_and_to_keep_what_it_holds(held: int, level: float) -> None:
    agent = _bass_agent("bass@all:partner=none")
    agent.reset(EpisodeInfo(SHORT.map, 0, 0, SHORT.ticks))
    state = replace(accuracy._state(SHORT, 3), held=np.array([-1, held]))
    chunk = acting(agent.guesses(np.ones((2, 8, 5), dtype=np.float32), state))
    angle = state.robot_poses[1, 2]
    assert chunk.shape == (2, 8, 4) and np.allclose(chunk, [0.0, np.cos(angle), np.sin(angle), level])
    assert bass_accuracy(agent, [SHORT], moments=1, seed=0).n == 1


def test_moments_of_episodes_that_drift_from_our_engine_are_as_recorded() -> None:
    """Imported episodes keep the states of the engine that they were played in."""
    shift = np.array([0.05, 0.0, 0.0]) * (np.arange(SHORT.ticks + 1) > 9)[:, None, None]
    drifting = replace(SHORT, robot_poses=SHORT.robot_poses + shift)
    for trajectory in (SHORT, drifting):
        for world, state in accuracy._moments(trajectory, [0, 5, 12, 20]):
            assert np.allclose(state.robot_poses, trajectory.robot_poses[state.tick], rtol=0, atol=1e-9)
            assert np.allclose(world.state().robot_poses, state.robot_poses, rtol=0, atol=1e-9)
