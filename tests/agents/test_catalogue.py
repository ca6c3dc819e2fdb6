"""From an id to an agent, and what is said when there is no way."""

import pytest

from agents.catalogue import agent_card, agent_cards, load_agent
from agents.errors import AgentError
from tests.agents.support import HERE, Forward


def test_every_card_names_an_agent_that_can_be_loaded() -> None:
    for card in agent_cards():
        assert callable(load_agent(card.id).act)
        assert card.description and card.name


def test_options_reach_a_factory_of_the_user_with_their_types() -> None:
    agent = load_agent(f"{HERE}:Forward:rows=3,distance=0.5")
    assert isinstance(agent, Forward)
    assert (agent.rows, agent.distance) == (3, 0.5)


@pytest.mark.parametrize(
    ("agent_id", "sentence"),
    [
        ("scriptet", "unknown agent 'scriptet'; known: scripted, person, idle, bass@all, dp@all"),
        ("a b:c", "unknown agent"),
        ("no_such_module:Factory", "cannot import 'no_such_module'"),
        (f"{HERE}:Missing", "has no factory 'Missing'"),
        (f"{HERE}:Forward:speed=1", "options: rows, execute, distance"),
        (f"{HERE}:Forward:rows", "options are written key=value"),
        (f"{HERE}:broken_factory", "could not be made: RuntimeError: no weights here"),
        (f"{HERE}:not_an_agent", "has no reset"),
        ("idle:speed=3", "options: none"),
    ],
)
def test_a_wrong_id_is_answered_with_a_sentence(agent_id: str, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        load_agent(agent_id)
    assert sentence in str(raised.value)


def test_a_card_of_a_users_agent_is_made_without_importing_it() -> None:
    card = agent_card("no_such_module:Factory")
    assert (card.id, card.name, card.kind) == ("no_such_module:Factory", "Factory", "policy")
    with pytest.raises(AgentError, match="known: scripted, person, idle"):
        agent_card("HandOf")


def test_a_trained_agent_that_does_not_exist_is_answered_with_those_that_do() -> None:
    for ask in (agent_card, load_agent):
        with pytest.raises(AgentError, match="dp@nowhere"):
            ask("dp@nowhere")
