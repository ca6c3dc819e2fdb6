"""The decision on a mirrored state is the mirrored decision, within sampling noise, where `mirrored=yes` says so."""

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import MapSpec, load_map
from movingout.world.state import Floats, WorldState

DECISIONS = 64
MAPS = ("HandOff", "FourCorners", "generated:awareness:1", "generated:coordination:0")
SIN = np.array([1, 1, -1, 1, 1])


def mirrored(state: WorldState) -> WorldState:
    """Left and right exchanged."""
    signs = np.array([-1, 1, -1])
    return replace(
        state,
        robot_poses=state.robot_poses * signs,
        robot_velocities=state.robot_velocities * signs,
        item_poses=state.item_poses * signs,
    )


def states_of(the_map: MapSpec) -> list[WorldState]:
    pair = load_agent("greedy:seed=1"), load_agent("greedy:seed=2")
    return [step.before for step in rollout(the_map, pair, seed=0, ticks=41)]


def decisions(agent_id: str, the_map: MapSpec, past: Sequence[WorldState], seat: int, seed: int) -> Floats:
    """(N, H, 5) in the state at the end of `past`."""
    agent = cast(PolicyAgent, load_agent(agent_id))
    agent.reset(EpisodeInfo(the_map, seat, seed, 500))
    for state in past:
        agent._past.append(state)
    agent._remember(observe(the_map, past[-1], seat))
    histories = np.stack([agent._stacked()] * DECISIONS)
    return np.array(PolicyAgent.decide_many([agent] * DECISIONS, [past[-1]] * DECISIONS, histories), np.float64)


def distance(one: Floats, other: Floats) -> float:
    """Mean square of the differences of means in standard errors: about 1 for two samples of one distribution."""
    errors = np.sqrt((one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / DECISIONS) + 1e-3
    return float((((one.mean(axis=0) - other.mean(axis=0)) / errors) ** 2).mean())


def test_the_decision_on_the_mirrored_state_is_the_mirrored_decision() -> None:
    same, through = [], []
    for name in MAPS:
        the_map, turned = load_map(name), load_map(f"{name}:mirror")
        states = states_of(the_map)
        for tick, seat in ((0, 0), (0, 1), (40, 0), (40, 1)):
            past = states[: tick + 1]
            one, other = (decisions("dp@any:mirrored=yes", the_map, past, seat, seed) for seed in (1, 2))
            image = decisions("dp@any:mirrored=yes", turned, [mirrored(state) for state in past], seat, 3)
            same.append(distance(one, other))
            through.append(distance(one, image * SIN))
    assert np.mean(same) < 1.5, "the measure itself"
    assert np.mean(through) < 1.5


@pytest.mark.parametrize("name", MAPS)
def test_bass_decides_on_the_mirrored_state_what_is_the_mirror_image(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exactly: what is drawn directly here is drawn through the mirror there, with the same noise."""
    here, there = load_map(name), load_map(f"{name}:mirror")
    past = states_of(here)
    seen = []
    for the_map, states, chances in (
        (here, past, (True, False, False, True, True, False)),
        (there, [mirrored(state) for state in past], (False, True, True, False, False, True)),
    ):
        agent = cast(PolicyAgent, load_agent("bass@any:mirrored=yes"))
        agent.reset(EpisodeInfo(the_map, 0, 1, 500))
        monkeypatch.setattr(agent, "flips", lambda count, chances=chances: list(chances[:count]))
        agent._past.extend(states)
        agent._remember(observe(the_map, states[-1], 0))
        decided = np.array(agent.decide(states[-1], agent._stacked()), np.float64)
        seen.append((np.array(agent.detail["scores"]), decided))
    (scores, chunk), (image_scores, image) = seen
    assert len(scores) == 4 and np.ptp(scores) > 0
    np.testing.assert_allclose(image_scores, scores, atol=2e-3)  # contacts in the engine are not quite symmetric
    np.testing.assert_allclose(image, chunk * SIN, atol=1e-3)


def test_the_option_is_off_unless_it_is_asked_for() -> None:
    the_map = load_map("HandOff")
    past = [next(rollout(the_map, (load_agent("idle"), load_agent("idle")), seed=0, ticks=1)).before]
    plain, off, on = (
        decisions(f"dp@any{option}", the_map, past, 0, 1) for option in ("", ":mirrored=no", ":mirrored=yes")
    )
    assert np.array_equal(plain, off) and not np.array_equal(plain, on)
    assert np.array_equal(on, decisions("dp@any:mirrored=yes", the_map, past, 0, 1)), "the same seed decides the same"


def test_a_batch_of_both_decides_as_each_alone() -> None:
    the_map = load_map("HandOff")
    first = observe(the_map, next(rollout(the_map, (load_agent("idle"),) * 2, seed=0, ticks=1)).before, 0)

    def fresh() -> list[PolicyAgent]:
        agents = [cast(PolicyAgent, load_agent(f"dp@any:mirrored={word}")) for word in ("no", "yes", "yes", "yes")]
        for seed, agent in enumerate(agents):
            agent.reset(EpisodeInfo(the_map, 0, seed, 500))
        return agents

    together = PolicyAgent.act_many(fresh(), [first] * 4)
    for alone, agent in zip(together, fresh(), strict=True):
        np.testing.assert_allclose(agent.act(first), alone, atol=1e-5)


@pytest.mark.parametrize(
    ("agent_id", "sentence"),
    [
        ("dp@all:mirrored=yes", "mirrored=yes is for agents that see their own frame, not the layout aware-v1"),
        ("dp@any:mirrored=perhaps", "mirrored is yes or no, not 'perhaps'"),
        ("bass@any:mirrored=perhaps", "mirrored is yes or no, not 'perhaps'"),
        ("bass@all:mirrored=yes", "mirrored=yes is for agents that see their own frame, not the layout aware-v1"),
    ],
)
def test_where_there_is_no_mirror_it_is_refused(agent_id: str, sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        load_agent(agent_id)
