"""A partner out of the model: who it is follows from its seed and the episode, or from its option."""

from pathlib import Path

import numpy as np
import pytest

from movingout.agents.action_chunk import checked_chunk
from movingout.agents.base import ActionChunk, EpisodeInfo
from movingout.agents.catalogue import agent_cards, load_agent
from movingout.agents.conformance import check_agent
from movingout.agents.errors import AgentError
from movingout.agents.generative.agent import LatentAgent
from movingout.agents.generative.latent_option import latent_text, parsed_latent
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from tests.agents.generative.toy import MODEL, untrained

HERE = load_map("HandOff")


@pytest.fixture(autouse=True)
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model with random weights, where commands look for it."""
    monkeypatch.chdir(tmp_path)
    untrained(tmp_path / "data" / "models")


def _seated(options: str, seed: int = 0, seat: int = 0) -> LatentAgent:
    agent = load_agent(f"{MODEL}{options}")
    assert isinstance(agent, LatentAgent)
    agent.reset(EpisodeInfo(HERE, seat, seed, 100))
    return agent


def _chunk(agent: LatentAgent) -> ActionChunk:
    return checked_chunk(agent.act(observe(HERE, start_state(HERE), agent.episode.seat)))


def test_two_latents_answer_differently_and_one_the_same() -> None:
    one, same, other = (_chunk(_seated(f":z={z}")) for z in ("1/0/0", "1/0/0", "-2/0.5/1"))
    assert np.array_equal(one, same) and np.abs(one - other).max() > 1e-3


def test_who_is_drawn_follows_from_seed_episode_and_seat() -> None:
    drawn = [_seated(options, seed, seat).latent for options, seed, seat in (
        (":seed=3", 5, 0), (":seed=3", 5, 0), (":seed=4", 5, 0), (":seed=3", 6, 0), (":seed=3", 5, 1)
    )]  # fmt: skip
    assert np.array_equal(drawn[0], drawn[1])
    assert len({latent.tobytes() for latent in drawn}) == 4
    many = np.array([_seated("", seed).latent for seed in range(300)])
    assert np.abs(many.mean(axis=0)).max() < 0.2 and np.abs(many.std(axis=0) - 1.0).max() < 0.15


def test_a_drawn_partner_can_be_named_and_plays_the_same() -> None:
    drawn = _seated(":seed=3", 5)
    named = _seated(f":z={latent_text(drawn.latent)}", 5)
    assert np.allclose(drawn.latent, named.latent, atol=1e-3)
    assert np.allclose(_chunk(drawn), _chunk(named), atol=0.02)


def test_partners_decide_together_as_they_do_alone() -> None:
    agents = [_seated(f":z={z}") for z in ("1/0/0", "-2/0.5/1")]
    alone = [_chunk(_seated(f":z={z}")) for z in ("1/0/0", "-2/0.5/1")]
    seen = observe(HERE, start_state(HERE), 0)
    together = PolicyAgent.act_many(agents, [seen, seen])
    assert np.array_equal(together, alone)


def test_it_meets_the_rules_and_is_not_offered_to_people() -> None:
    check_agent(lambda: load_agent(MODEL), ["HandOff"], 20)
    (card,) = [card for card in agent_cards() if card.id == MODEL]
    assert not card.offered


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (":z=1/2", "z has 3 numbers in this model, not 2: '1/2'"),
        (":z=0.5", "z has 3 numbers in this model, not 1: '0.5'"),
        (":z=1/x/2", "z is 3 numbers joined by /"),
        (":z=1/nan/2", "lie between -8 and 8"),
        (":z=1/9/2", "lie between -8 and 8"),
        (":seed=x", "seed is a whole number, not 'x'"),
        (":age=3", "options: seed, z, execute"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(options: str, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        load_agent(f"{MODEL}{options}")
    assert sentence in str(raised.value)


def test_a_model_that_is_not_there_is_named() -> None:
    with pytest.raises(AgentError, match="no checkpoint 'latent@nowhere'"):
        load_agent("latent@nowhere:seed=1")


def test_text_and_latent_are_each_others_inverse() -> None:
    latent = np.array([0.25, -1.5, 3.0], dtype=np.float32)
    assert np.array_equal(parsed_latent(latent_text(latent), 3), latent)
