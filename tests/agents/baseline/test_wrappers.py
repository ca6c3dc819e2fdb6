"""What is put around an agent has what that agent has besides its answers."""

from collections.abc import Callable
from typing import cast

import pytest

from movingout.agents import catalogue
from movingout.agents.base import Agent, Wrapper
from movingout.agents.baseline.delayed_agent import DelayedAgent
from movingout.agents.baseline.timed_agent import TimedAgent
from movingout.agents.catalogue import load_live_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.late_hands import LateHands
from movingout.maps import load_map
from movingout.world import World
from tests.agents.support import Forward


class _Oracle(Forward):
    deterministic = False
    waits = True
    not_played = "asleep"

    def __init__(self, *numbers: int) -> None:
        super().__init__(*numbers)
        self.episode_counts = {"questions": 3}

    def watch(self, world: World) -> None:
        self.world = world


@pytest.mark.parametrize("around", [TimedAgent, LateHands, lambda agent: DelayedAgent(agent, 1)])
def test_what_the_agent_inside_has_is_passed_on(around: Callable[[Agent], Wrapper]) -> None:
    inside, world = _Oracle(1, 1), World(load_map("HandOff"))
    agent = around(cast(Agent, around(inside)))
    agent.watch(world)
    assert inside.world is world
    assert (agent.detail, agent.deterministic, agent.waits) == (inside.detail, False, True)
    assert (agent.episode_counts, agent.not_played) == ({"questions": 3}, "asleep")


def test_no_room_takes_an_agent_that_waits_however_often_it_is_wrapped(monkeypatch: pytest.MonkeyPatch) -> None:
    agent: Agent = DelayedAgent(LateHands(_Oracle(1, 1)), 1)
    monkeypatch.setattr(catalogue, "load_admitted_agent", lambda agent_id: agent)
    with pytest.raises(AgentError, match="late:agent=llm waits for its answers"):
        load_live_agent("late:agent=llm")
