import numpy as np
import pytest

from agents.base import BatchAgent, EpisodeInfo
from agents.observing import observe
from agents.policies.export import export_policy
from agents.policies.policy import build_policy
from agents.serving import PolicyAgent, PolicyNetwork
from maps import load_map
from tests.agents.learning import random_walk, states_of, tiny_spec

torch = pytest.importorskip("torch")


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
