"""The agents that come with the project: they load, say how good they are, and play maps they never saw."""

import numpy as np
import pytest

from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.bass.agent import BassAgent
from movingout.agents.bass.selection import pairs_of
from movingout.agents.bass.state_vector import held_of
from movingout.agents.catalogue import load_agent, trained_cards
from movingout.agents.checkpoint.checkpoint import SHIPPED, checkpoint_folders, read_checkpoint
from movingout.agents.data.rollout import rollout
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.kinds.registry import KINDS
from movingout.agents.scripted import ScriptedAgent
from movingout.maps import MapSpec, load_map
from movingout.maps.randomize import randomize

FOLDERS = list(checkpoint_folders(SHIPPED))
CARDS = [read_checkpoint(folder).card for folder in FOLDERS]
IDS = [card.id for card in CARDS]
HELPERS = [card.id for card in CARDS if KINDS[card.kind].offered]  # the others are partners to train and measure with
MAX_BYTES = 9_000_000  # of one agent's folder
BASELINES = ("mlp@all", "gru@all")  # the paper's, for comparison: they need not help
UNSEEN = [load_map("Simple"), randomize(load_map("HandOff"), 12)]


@pytest.mark.parametrize("agent_id", IDS)
def test_a_shipped_agents_files_are_those_of_its_card_and_small(agent_id: str) -> None:
    checkpoint = read_checkpoint(FOLDERS[IDS.index(agent_id)])
    assert sum(len(checkpoint.read(entry.name)) for entry in checkpoint.card.files) < MAX_BYTES


@pytest.mark.parametrize("agent_id", HELPERS)
def test_a_shipped_agent_says_how_good_it_is_beside_the_control(agent_id: str) -> None:
    scores = read_checkpoint(FOLDERS[IDS.index(agent_id)]).card.scores
    assert all(score.n >= 20 and score.stderr > 0 for score in scores.values())
    control = scores["TCR of these people with an idle partner"]
    helps = scores["TCR with unseen scripted people"].mean > control.mean + 2 * control.stderr
    assert helps or agent_id in BASELINES
    assert agent_id in {card.id for card in trained_cards()}


@pytest.mark.parametrize("agent_id", IDS)
@pytest.mark.parametrize("the_map", UNSEEN, ids=["practice room", "randomised"])
def test_a_shipped_agent_plays_a_map_it_never_saw(agent_id: str, the_map: MapSpec) -> None:
    steps = list(rollout(the_map, (load_agent(agent_id), IdleAgent()), seed=1, ticks=25))
    actions = np.array([step.actions for step in steps])
    assert np.isfinite(actions).all() and np.abs(actions[:, 0, 0]).max() > 0.1


@pytest.mark.parametrize(("sampling", "pairs"), [("4", 4), ("2x2", 4), ("4x4", 16), ("8x2", 16)])
def test_a_sampling_is_chosen_in_the_id_as_the_documentation_says(sampling: str, pairs: int) -> None:
    agent = load_agent(f"bass@all:sampling={sampling}")
    assert isinstance(agent, BassAgent)
    assert len(pairs_of(agent.selection)) == pairs


def test_a_policy_plays_alike_alone_and_beside_others() -> None:
    agent = load_agent("dp@all")
    assert isinstance(agent, PolicyAgent)
    network, random = agent.network, np.random.default_rng(0)
    histories = random.standard_normal((4, network.spec.obs_horizon, network.spec.features), dtype=np.float32)
    noise = network.noise(4, random)
    together = network.run(histories, noise)
    alone = [network.run(histories[row : row + 1], noise[row : row + 1])[0] for row in range(4)]
    assert np.array_equal(together, alone)


def test_the_simulator_of_bass_sees_that_a_press_takes_and_lets_go() -> None:
    agent = load_agent("bass@all")
    assert isinstance(agent, BassAgent)
    changes = 0
    for step in rollout(load_map("HandOff"), (agent, ScriptedAgent()), seed=2, ticks=200):
        levels = (step.before.held >= 0) ^ (step.actions[:, 2] > 0.5)
        joint = np.zeros((1, agent.selection.depth, 2, 4))
        joint[..., 0], joint[..., 1], joint[..., 3] = 0.5, 1.0, levels
        predicted = held_of(agent.simulator(step.before)(joint)[0, :1])[0]
        if step.before.held[0] != step.after.held[0]:  # blue, whose hand moves at the beginning of the tick
            changes += 1
            assert predicted[0] == step.after.held[0]
    assert changes >= 2
