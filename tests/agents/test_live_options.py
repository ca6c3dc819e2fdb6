"""Whether a room could play an agent, by its id alone."""

import pytest

from movingout.agents.catalogue import agent_cards, load_agent
from movingout.agents.errors import AgentError
from movingout.agents.inference import network
from movingout.agents.live_options import check_live_agent

POSSIBLE = (
    "scripted:seed=3,patience=40,yields=1", "person:name=B07", "greedy:order=far", "novice:learns_in=100", "idle:lag=3",
    "late:agent=scripted:seed=4;patience=40,delay=2", "late:agent=bass@any:sub_steps=20", "clone",
    "clone:policy=dp@any", "bass@any:mirrored=yes",
    "dp@any:mirrored=yes,execute=4", "gru@all:execute=2", "bass@any:partner=motion,sub_steps=20", "bass@all:sampling=4",
    "bass@all:simulator=engine", "bass@all:lag=1", "latent@families:seed=3", "latent@families:z=0/0/0/0/1/0/0/0",
    "self-play-0@families:age=young,temperature=0.5,seed=3",
)  # fmt: skip
IMPOSSIBLE = {
    "bass@any:partner=x": "partner=policy or",
    "bass@any:partner=random": "not engine, random",
    "bass@any:simulator=learned": "has no learned simulator",
    "bass@any:sampling=3": "sampling is one of 4, 2x2, 4x4, 8x2",
    "bass@any:sub_steps=7": "sub_steps is one of 20, 10",
    "bass@any:execute=99": "execute is a whole number of ticks from 1 to",
    "bass@any:speed=3": "options: execute, simulator, partner, sampling, score, sub_steps, mirrored",
    "bass@any:lag=11": "lag is a whole number of ticks from 1 to 10",
    "dp@any:mirrored=perhaps": "mirrored is yes or no",
    "dp@all:mirrored=yes": "own frame",
    "bass@all:mirrored=yes": "own frame",
    "bass@any:mirrored=2": "mirrored is yes or no",
    "mlp@all:execute=nan": "execute is a whole number",
    "latent@families:z=1/2": "z has 8 numbers",
    "latent@families:seed=x": "seed is a whole number",
    "self-play-0@families:age=middle": "unknown age 'middle'",
    "self-play-0@families:temperature=9": "temperature is a number from 0",
    "late:agent=bass@any:partner=x": "partner=policy or",
    "late:agent=late": "has late hands already",
    "late:delay=-1": "delay is a whole number of ticks from 0 to 10",
    "clone:policy=scripted": "policy is the id of a trained agent",
    "clone:keys=true": "options: policy, seed, delay, jitter, slips",
    "scripted:slices=x": "slices is a whole number from 1",
    "scripted:adapts=perhaps": "adapts is true or false",
    "scripted:patience=nan": "patience must lie between",
    "scripted:self=3": "unexpected keyword argument 'self'",
    "scripted:speed=3": "no habit 'speed'",
    "person:name=Z9": "there is no person 'Z9'",
    "scripted:seed": "options are written key=value",
}


@pytest.mark.parametrize("agent_id", [*POSSIBLE, *(card.id for card in agent_cards())])
def test_what_can_be_loaded_is_let_through(agent_id: str) -> None:
    check_live_agent(agent_id)
    load_agent(agent_id)


@pytest.mark.parametrize(("agent_id", "why"), IMPOSSIBLE.items())
def test_what_cannot_be_loaded_is_refused_for_the_same_reason(agent_id: str, why: str) -> None:
    with pytest.raises(AgentError) as refused:
        check_live_agent(agent_id)
    with pytest.raises(AgentError) as failed:
        load_agent(agent_id)
    assert why in str(refused.value)
    assert str(refused.value) == str(failed.value)


def test_an_oracle_that_needs_the_world_is_for_matches_alone() -> None:
    load_agent("bass@all:simulator=oracle")
    with pytest.raises(AgentError, match="needs the world itself"):
        check_live_agent("bass@all:simulator=oracle")


def test_no_weights_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(*_: object) -> None:
        raise AssertionError("a network was loaded")

    monkeypatch.setattr(network.Network, "__init__", read)
    for agent_id in POSSIBLE:
        check_live_agent(agent_id)
