"""What took the scripted pair longest to learn; the whole table is printed by `python -m bench scripted`."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.data.rollout import RolloutStep, SeatPlayer, rollout
from movingout.agents.scripted import ScriptedAgent
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.agents.scripted.navigation.pose_grid import SOLO_MOTION, grid_pose, next_pose
from movingout.agents.scripted.perception import Perception
from movingout.maps import load_map
from movingout.world import World
from movingout.world.scoring import delivered_items


def _last(name: str, ticks: int) -> RolloutStep:
    """The last tick of a pair of experts."""
    *_, last = rollout(load_map(name), (ScriptedAgent(), ScriptedAgent()), 0, ticks)
    return last


def test_a_pair_turns_the_large_item_through_the_gap_and_delivers_it() -> None:
    the_map = load_map("SingleRotation")
    last = _last("SingleRotation", 150)
    assert delivered_items(the_map, last.after.item_poses).all()
    assert last.after.tick < 150


@pytest.mark.parametrize("person", [0, 1])
def test_who_holds_the_large_item_anywhere_and_waits_is_joined_within_five_seconds(person: int) -> None:
    """A partner once stood at its corner for longer, and did not grab."""
    the_map = load_map("SingleRotation")
    start = World(the_map).state()
    now = Perception(the_map, start, person)
    poses, _ = stances(now.item(0), now.item_pose(0))
    for pose in poses[::5]:
        robots, held = start.robot_poses.copy(), np.array([-1, -1])
        robots[person], held[person] = pose, 0
        world = World.from_state(the_map, replace(start, robot_poses=robots, held=held))
        partner = SeatPlayer(ScriptedAgent(), EpisodeInfo(the_map, 1 - person, 0, 500))
        for _ in range(50):
            actions = np.array([[0.0, pose[2], 0.0]] * 2)
            actions[1 - person] = partner.action(world.state())
            world.step(actions)
        assert (world.state().held == 0).all(), f"held at {pose}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["PriorityPick", "AdaptiveAssist", "PassOrSplit"])
def test_a_pair_delivers_everything_where_room_is_scarce(name: str) -> None:
    the_map = load_map(name)
    assert delivered_items(the_map, _last(name, 500).after.item_poses).all()


def test_small_items_that_wait_are_not_in_the_way_for_good() -> None:
    the_map = load_map("AdaptiveAssist")
    now = Perception(the_map, World(the_map).state(), 0)
    heavy = {index for index in range(len(the_map.items)) if now.is_heavy(index)}
    assert {the_map.items.index(item) for item, *_ in now.lasting_space(0).items} == heavy
    assert len(now.space().items) == len(the_map.items)


def test_the_plan_is_followed_pose_by_pose() -> None:
    costs = np.full((SOLO_MOTION.headings, 81, 81), 30000, dtype=np.int16)
    costs[0, 40, 40], costs[0, 42, 40] = 4, 0
    assert next_pose(costs.ravel(), SOLO_MOTION, np.array([0.01, 0.0, 0.05])) == pytest.approx((0.0, 0.06, 0.0))
    assert next_pose(costs.ravel(), SOLO_MOTION, np.array([0.0, 0.06, 0.0])) == pytest.approx((0.0, 0.06, 0.0))


def test_the_nearest_grid_pose_keeps_the_turns_of_a_robot() -> None:
    assert grid_pose(SOLO_MOTION, np.array([0.31, -0.29, 2 * np.pi + 0.1])) == pytest.approx((0.3, -0.3, 2 * np.pi))
