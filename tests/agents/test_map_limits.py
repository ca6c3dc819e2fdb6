"""Whether an agent sees all of a map is that of the one that decides."""

from dataclasses import replace

import pytest

from movingout.agents.errors import AgentError
from movingout.agents.map_limits import check_map_seen, check_own_maps_seen
from movingout.maps import MapSpec, load_map, map_from_json, map_to_json


@pytest.fixture
def five_goals() -> MapSpec:
    """A goal more than trained agents see."""
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    return map_from_json(map_to_json(load_map("Simple")) | {"name": "Five", "title": "Five", "goals": goals})


@pytest.mark.parametrize(
    "agent_id", ["dp@all", "clone", " clone:delay=2", "clone:policy=dp@all", "late:agent=dp@all:execute=2,delay=1"]
)
def test_agents_that_decide_from_less_than_the_map_are_refused(agent_id: str, five_goals: MapSpec) -> None:
    with pytest.raises(AgentError, match=rf"{agent_id} cannot play five\.json: .* 4 slots for goals; Five has 5"):
        check_map_seen(agent_id, five_goals, "five.json")


@pytest.mark.parametrize("agent_id", ["late", "late:agent=scripted", "idle", "my_package.policy:Mine"])
def test_others_play_it(agent_id: str, five_goals: MapSpec) -> None:
    check_map_seen(agent_id, five_goals)


def test_whoever_plays_a_map_of_ones_own_is_looked_at(five_goals: MapSpec) -> None:
    check_own_maps_seen([("dp@all", load_map("HandOff:rot90")), ("idle", five_goals)])
    with pytest.raises(AgentError, match=r"dp@all cannot play Five: .* 4 slots for goals; Five has 5"):
        check_own_maps_seen([("idle", five_goals), ("dp@all", five_goals)])


def test_a_map_of_ones_own_is_looked_at_under_any_name(five_goals: MapSpec) -> None:
    with pytest.raises(AgentError, match=r"dp@all cannot play HandOff: .* 4 slots for goals; HandOff has 5"):
        check_own_maps_seen([("dp@all", replace(five_goals, name="HandOff"))])
