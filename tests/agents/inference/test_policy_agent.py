"""Trained agents at play."""

import dataclasses
import subprocess
import sys

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.kinds.policy import build_policy
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.policies.export import export_policy
from movingout.maps import load_map
from tests.agents.learning import tiny_spec


def test_playing_needs_no_torch() -> None:
    modules = "movingout.agents.inference.policy_agent, movingout.agents.bass.agent, sys"
    code = f"import {modules}; assert 'torch' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def _agent(**changes: object) -> PolicyAgent:
    spec = tiny_spec(**changes)
    agent = PolicyAgent(spec, PolicyNetwork(spec, export_policy(build_policy(spec).eval())))
    agent.reset(EpisodeInfo(load_map("HandOff"), 0, 3, 100))
    return agent


def test_a_plan_is_played_for_the_ticks_that_it_is_meant_for_and_then_made_anew() -> None:
    agent = _agent(execute=3, obs_horizon=1)
    the_map = load_map("HandOff")
    state = start_state(the_map)
    answers = [agent.act(observe(the_map, state, 0, tick)) for tick in range(4)]
    assert [len(answer) for answer in answers] == [8, 7, 6, 8]
    assert np.array_equal(answers[1][:, :3], answers[0][1:, :3])
    assert not np.array_equal(answers[3][0], answers[0][0])  # fresh noise


def test_an_episode_is_repeated_by_its_seed() -> None:
    agent = _agent()
    the_map = load_map("HandOff")
    first = agent.act(observe(the_map, start_state(the_map), 0))
    agent.reset(EpisodeInfo(the_map, 0, 3, 100))
    assert np.array_equal(first, agent.act(observe(the_map, start_state(the_map), 0)))
    agent.reset(EpisodeInfo(the_map, 0, 4, 100))
    assert not np.array_equal(first, agent.act(observe(the_map, start_state(the_map), 0)))


def test_ticks_that_were_missed_make_it_decide_anew() -> None:
    agent = _agent(execute=2)
    the_map = load_map("HandOff")
    state = start_state(the_map)
    agent.act(observe(the_map, state, 0, 0))
    assert len(agent.act(observe(the_map, state, 0, 17))) == 8


def test_noise_is_wider_after_two_seconds_on_the_spot_and_until_it_moves() -> None:
    agent = _agent(restless=2.0, obs_horizon=1)
    the_map = load_map("HandOff")
    here = start_state(the_map)
    poses = here.robot_poses.copy()
    poses[0, 0] += 0.1
    there = dataclasses.replace(here, robot_poses=poses)
    widths = []
    for tick, state in enumerate([here] * 25 + [there]):
        agent.act(observe(the_map, state, 0, tick))
        plain = np.random.default_rng()
        plain.bit_generator.state = agent.random.bit_generator.state
        widths.append(float(np.median(agent.noise(1) / agent.network.noise(1, plain))))
        agent.random.bit_generator.state = plain.bit_generator.state
    assert widths == [1.0] * 19 + [2.0] * 6 + [1.0]
