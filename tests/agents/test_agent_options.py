"""The options of an agent's id as values."""

import pytest

from movingout.agents.agent_options import OptionValue, checked_options, parse_options
from movingout.agents.catalogue import agent_card, load_agent, load_live_agent
from movingout.agents.errors import AgentError
from movingout.agents.live_options import check_admitted_agent, check_live_agent
from movingout.agents.partners.identity import person_behind


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3), ("-0.5", -0.5), ("1e3", "1e3"), ("1.10", "1.10"), ("007", "007"), ("2026_11", "2026_11"),
        ("True", True), ("false", False), ("yes", "yes"),
        ("nan", "nan"), ("inf", "inf"), ("-Infinity", "-Infinity"), ("1e999", "1e999"), ("9" * 400, int("9" * 400)),
    ],
)  # fmt: skip
def test_finite_numbers_are_numbers_and_all_else_is_text(text: str, value: OptionValue) -> None:
    found = parse_options("mine:Agent", f"how={text}")["how"]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    "agent_id", ["mine:Agent:seed=1,seed=2", "greedy:patience=60, patience=60", "late:agent=greedy:seed=1;seed=2"]
)
def test_an_option_that_stands_twice_is_refused(agent_id: str) -> None:
    with pytest.raises(AgentError, match=r"(seed|patience) stands twice in its options; leave one out"):
        load_agent(agent_id)
    with pytest.raises(AgentError, match="stands twice"):
        check_live_agent(agent_id)


def numbers_of(agent: object) -> list[object]:
    """What it and the agent inside were made with."""
    inside = vars(agent).get("agent")
    own = [value for value in vars(agent).values() if isinstance(value, int | float)]
    return own + (numbers_of(inside) if inside else [])


def test_in_a_study_that_began_with_an_option_twice_the_last_one_counts() -> None:
    for agent_id, once in (
        ("late:agent=greedy,delay=1,delay=2", "late:agent=greedy,delay=2"),
        ("late:agent=greedy:seed=1;seed=2", "late:agent=greedy:seed=2"),
        ("scripted:lag=1,lag=5", "scripted:lag=5"),
    ):
        check_admitted_agent(agent_id)
        assert agent_card(agent_id).id == agent_card(once).id
        assert numbers_of(load_live_agent(agent_id)) == numbers_of(load_live_agent(once)) != []


def test_what_was_recorded_of_agents_with_an_option_twice_is_still_theirs() -> None:
    assert person_behind("late:agent=greedy,delay=1,delay=2") == "greedy"


def _takes(path: str, noise: float = 1.0, seed=0, scale: "float | None" = None, tag=None) -> None:  # type: ignore[no-untyped-def]
    """A factory whose parameters are declared, have a default, or neither."""


def test_where_the_factory_takes_a_number_it_gets_one_however_it_is_written() -> None:
    options = parse_options("mine:Agent", "path=007,noise=1e-1,seed=03,scale=0.50,tag=1.10")
    taken = {"path": "007", "noise": 0.1, "seed": 3, "scale": 0.5, "tag": 1.1}
    assert checked_options("mine:Agent", _takes, options) == taken
    wrong = parse_options("mine:Agent", "path=p,noise=1e999")
    assert checked_options("mine:Agent", _takes, wrong)["noise"] == "1e999"


def test_shipped_agents_take_numbers_as_ids_of_before_wrote_them() -> None:
    for agent_id in (
        "self-play-0@families:temperature=0.50",
        "late:agent=greedy,jitter=1e-1,delay=02",
        "novice:seed=07",
        "person:speed=0.80",
        "scripted:lag=05",
    ):
        check_live_agent(agent_id)
        load_agent(agent_id)
