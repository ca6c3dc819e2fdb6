"""Options that are offered make sense in the state at hand, and the controller carries them out."""

from dataclasses import replace

import numpy as np

from movingout.agents.partners.options.option import MOST_OPTIONS, WAIT, RobotOption, command_of, offered, spot_in
from movingout.agents.partners.walking import Perceiver
from movingout.agents.scripted.perception import Perception
from movingout.maps import load_map
from movingout.maps.shapes import circumradius
from movingout.world.state import WorldState
from tests.agents.partners.scenes import BLUE, RED, holding, scene

MAP = "HandOff"
SPEC = load_map(MAP)
LIGHT = next(index for index, item in enumerate(SPEC.items) if item.size == "small")
HEAVY_MAP = "AdaptiveAssist"
HEAVY = next(index for index, item in enumerate(load_map(HEAVY_MAP).items) if item.size != "small")


def seen(state: WorldState, map_name: str = MAP, seat: int = BLUE) -> Perception:
    return Perceiver(load_map(map_name), seat).perceive(state)


def taken(now: Perception) -> set[int]:
    return {option.item for option in offered(now) if option.kind == "take"}


def lying_in(item: int, goal: int) -> WorldState:
    """An item in the middle of a goal region."""
    region, state = SPEC.goals[goal], scene(MAP)
    poses = state.item_poses.copy()
    poses[item, :2] = (region.left + region.right) / 2, (region.bottom + region.top) / 2
    return replace(state, item_poses=poses)


def test_with_an_empty_hand_every_item_can_be_taken_and_waiting_is_possible() -> None:
    options = offered(seen(scene(MAP)))
    assert options[0] == WAIT and {option.kind for option in options} == {"wait", "take"}
    assert taken(seen(scene(MAP))) == set(range(len(SPEC.items)))


def test_what_is_delivered_is_not_taken() -> None:
    assert LIGHT not in taken(seen(lying_in(LIGHT, 0)))


def test_a_light_item_that_the_partner_has_is_left_to_it_and_a_heavy_one_is_not() -> None:
    assert LIGHT not in taken(seen(holding(MAP, LIGHT, RED)))
    assert HEAVY in taken(seen(holding(HEAVY_MAP, HEAVY, RED), HEAVY_MAP))


def test_with_an_item_each_goal_region_and_letting_go_are_offered() -> None:
    options = offered(seen(holding(MAP, LIGHT)))
    assert [option.kind for option in options] == ["wait", "let go", *["carry"] * len(SPEC.goals)]
    assert {option.item for option in options[1:]} == {LIGHT}
    assert [option.goal for option in options[2:]] == list(range(len(SPEC.goals)))


def test_of_very_many_items_the_nearest_are_offered() -> None:
    many = replace(SPEC, items=SPEC.items[:1] * (MOST_OPTIONS + 5))
    state = scene(MAP)
    poses = np.tile(state.item_poses[:1], (len(many.items), 1))
    poses[:, 0] = np.linspace(-0.9, 0.9, len(poses))
    now = Perceiver(many, BLUE).perceive(replace(state, item_poses=poses))
    assert len(offered(now)) == MOST_OPTIONS
    away = np.abs(poses[:, 0] - now.pose[0])
    assert int(np.argmax(away)) not in taken(now) and int(np.argmin(np.hypot(*(poses - now.pose)[:, :2].T))) in taken(
        now
    )


def test_the_spot_is_in_its_region_and_beside_what_lies_there() -> None:
    goal, other = SPEC.goals[0], next(index for index in range(len(SPEC.items)) if index != LIGHT)
    empty, full = spot_in(seen(scene(MAP)), LIGHT, 0), spot_in(seen(lying_in(other, 0)), LIGHT, 0)
    for x, y in (empty, full):
        assert goal.left - 0.05 <= x <= goal.right + 0.05 and goal.bottom - 0.05 <= y <= goal.top + 0.05
    middle = np.array([(goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2])
    assert np.hypot(*(empty - middle)) < 0.05
    assert np.hypot(*(full - middle)) > circumradius(SPEC.items[LIGHT].shape, SPEC.items[LIGHT].scale)


def test_letting_go_presses_and_waiting_gives_room_only_to_one_who_is_near() -> None:
    now = seen(holding(MAP, LIGHT))
    assert command_of(RobotOption("let go", LIGHT), now).grasp
    state = scene(MAP)
    assert command_of(WAIT, seen(state)).distance == 0.0
    near = state.robot_poses.copy()
    near[RED] = near[BLUE] + [0.25, 0.0, 0.0]
    assert command_of(WAIT, seen(replace(state, robot_poses=near))).distance != 0.0


def test_a_light_item_near_its_spot_is_shifted_to_it_forwards_or_backwards() -> None:
    now = seen(holding(MAP, LIGHT))
    x, y, _ = now.item_pose(LIGHT).tolist()
    ahead, behind = (command_of(RobotOption("carry", LIGHT, 0, (x, y + way)), now) for way in (0.2, -0.2))
    assert (ahead.distance, behind.distance) == (1.0, -1.0)
    assert abs(np.sin(ahead.heading)) < 1e-6 and abs(np.sin(behind.heading)) < 1e-6
