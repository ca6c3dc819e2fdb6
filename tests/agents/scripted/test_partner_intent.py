"""The expert reads what its partner means: the item it goes to, whether it comes, and the goal it pulls to."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.observation.seat_observation import start_state
from movingout.agents.scripted.human_model import HumanModel
from movingout.agents.scripted.navigation.motion_choice import REST, drive
from movingout.agents.scripted.partner_intent import PartnerIntent
from movingout.maps import load_map
from movingout.world import World
from movingout.world.state import WorldState
from tests.agents.scripted.arena import BLUE, RED, goal_middle, heading_to, shared_item_map


def _walked(map_name: str, item: int, share: float, ticks: int = 12) -> tuple[PartnerIntent, WorldState]:
    """What red knows of a blue that has walked `share` of the straight line to an item (negative: away from it)."""
    the_map = load_map(map_name)
    state, intent = start_state(the_map), PartnerIntent(the_map, RED)
    start, goal = state.robot_poses[BLUE, :2].copy(), state.item_poses[item, :2]
    for tick in range(ticks):
        poses = state.robot_poses.copy()
        poses[BLUE, :2] = start + share * tick / (ticks - 1) * (goal - start)
        state = replace(state, tick=tick, robot_poses=poses)
        intent.observe(state)
    return intent, state


@pytest.mark.parametrize("item", range(4))
@pytest.mark.parametrize("name", ["FourCorners", "FourCorners:mirror", "FourCorners:rot90"])
def test_it_sees_to_which_item_the_partner_goes(name: str, item: int) -> None:
    intent, state = _walked(name, item, 0.6)
    assert intent.meant(state, list(range(4))) == item
    assert intent.is_coming(state, item)


def test_a_partner_that_stands_goes_away_or_has_something_in_its_hand_comes_to_nothing() -> None:
    for share in (0.0, -0.3):
        intent, state = _walked("FourCorners", 0, share)
        assert not intent.is_coming(state, 0)
    assert _walked("FourCorners", 0, 0.0)[0].meant(state, list(range(4))) == -1
    intent, state = _walked("FourCorners", 0, 0.6)
    busy = replace(state, held=np.array([1, -1]))
    assert intent.meant(busy, list(range(4))) == -1 and not intent.is_coming(busy, 0)


def test_who_stands_beside_an_item_is_about_to_take_it_but_not_for_long() -> None:
    intent, state = _walked("FourCorners", 0, 0.62)
    near = state.item_poses[0] + np.array([-0.3, 0.0, 0.0])
    believed = []
    for tick in range(40):
        beside = replace(state, tick=20 + tick, robot_poses=np.stack([near, state.robot_poses[RED]]))
        intent.observe(beside)
        believed.append(intent.is_coming(beside, 0))
    assert believed[15] and not believed[-1]


@pytest.mark.parametrize("goal", range(4))
@pytest.mark.parametrize("resists", [False, True])
def test_it_feels_to_which_goal_the_partner_pulls_a_shared_item(goal: int, resists: bool) -> None:
    the_map = shared_item_map()
    world, intent = World(the_map), PartnerIntent(the_map, RED)
    place = goal_middle(the_map, goal)
    for tick in range(9):
        state = world.state()
        intent.observe(state)
        x, y, _ = state.item_poses[0].tolist()
        heading = heading_to(x, y, place)
        command = drive(heading + 2.0, 0.8) if resists else REST
        intent.commanded(command)
        press = float(tick == 0)
        angle = float(state.robot_poses[RED, 2])
        red = (0.0, angle, press) if tick == 0 else (command.distance, command.heading, 0.0)
        world.step(np.array([(float(tick > 0), heading, press), red]))
    state = world.state()
    assert state.held.tolist() == [0, 0]
    intent.observe(state)
    assert intent.goal_pulled_to(state, 0) == goal


def test_people_take_their_partner_for_their_like_as_before() -> None:
    assert HumanModel("C01")._plan.adapts is False
