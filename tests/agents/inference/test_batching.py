import numpy as np
import pytest

from movingout.agents.base import BatchAgent, EpisodeInfo
from movingout.agents.bass.agent import BassAgent
from movingout.agents.bass.checkpoint_parts import export_dynamics
from movingout.agents.bass.dynamics import build_dynamics
from movingout.agents.checkpoint.card import DynamicsSpec, SelectionSpec
from movingout.agents.inference.network import Network, PolicyNetwork
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.kinds.policy import build_policy
from movingout.agents.observation.seat_observation import observe
from movingout.agents.policies.export import export_policy
from movingout.maps import load_map
from tests.agents.learning import random_walk, states_of, tiny_spec

torch = pytest.importorskip("torch")


def _bass_agents(count: int) -> list[BassAgent]:
    spec, shape = tiny_spec(width=64), DynamicsSpec(width=64, latent=16, rigid=True)
    network = PolicyNetwork(spec, export_policy(build_policy(spec)))
    dynamics = Network(export_dynamics(build_dynamics(shape), 8, spec.grasp))
    return [BassAgent(spec, network, dynamics, SelectionSpec()) for _ in range(count)]


def test_bass_agents_asked_together_choose_to_the_bit_what_each_chooses_alone() -> None:
    torch.manual_seed(0)
    agents = _bass_agents(10)
    together, alone = agents[:5], agents[5:]
    places = [load_map(name) for name in ("HandOff", "HandOff", "DistancePriority", "DistancePriority", "HandOff")]
    for group in (together, alone):
        for seed, (agent, the_map) in enumerate(zip(group, places, strict=True)):
            agent.reset(EpisodeInfo(the_map, seed % 2, seed, 100))
    trajectories = {the_map: states_of(the_map, random_walk(5, seed=1)) for the_map in places}
    for states in zip(*(trajectories[the_map] for the_map in places), strict=True):
        seen = [
            observe(the_map, state, agent.episode.seat)
            for the_map, state, agent in zip(places, states, together, strict=True)
        ]
        answers = BassAgent.act_many(together, seen)
        for answer, agent, mate, observation in zip(answers, alone, together, seen, strict=True):
            assert np.array_equal(answer, agent.act(observation))
            assert agent.detail == mate.detail


@pytest.mark.parametrize("shape", [{"kind": "dp", "width": 256, "depth": 2}, {"kind": "gru", "obs_horizon": 3}])
def test_agents_asked_together_answer_to_the_bit_what_each_answers_alone(shape: dict[str, object]) -> None:
    torch.manual_seed(0)
    spec = tiny_spec(**shape)
    network = PolicyNetwork(spec, export_policy(build_policy(spec)))
    the_map = load_map("HandOff")
    together, alone = ([PolicyAgent(spec, network) for _ in range(7)] for _ in range(2))
    for agents in (together, alone):
        for seed, agent in enumerate(agents):
            agent.reset(EpisodeInfo(the_map, seed % 2, seed, 100))
    assert isinstance(together[0], BatchAgent)
    for state in states_of(the_map, random_walk(9, seed=1)):
        seen = [observe(the_map, state, agent.episode.seat) for agent in together]
        answers = type(together[0]).act_many(together, seen)
        for answer, agent, observation in zip(answers, alone, seen, strict=True):
            assert np.array_equal(answer, agent.act(observation))
