"""Cooperation in little room: waiting for the partner, leaving items to it, and never stalling for good."""

from dataclasses import replace
from typing import Any

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.navigation.free_space import with_robot
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.agents.scripted.navigation.motion_choice import no_collision_cost
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.task_choice import IDLE_AFTER, WAITS_HOLDING_FOR, TaskSelector
from movingout.agents.scripted.tasks.approach import stance_costs
from movingout.agents.scripted.tasks.fetch import Carry, Fetch
from movingout.agents.scripted.tasks.grasp_pairs import LEAST_DISTANCE, tight_stance_costs
from movingout.agents.scripted.tasks.lift import RELEASE_AFTER as PAIR_RELEASE_AFTER
from movingout.agents.scripted.tasks.lift import RELEASE_AT_HOME_AFTER, Lift
from movingout.agents.scripted.tasks.wait import Aside
from movingout.maps import load_map
from movingout.maps.flood_fill import UNREACHED
from movingout.world import World

THINK = 1000  # slices: to the end


def _situation(name: str, tick: int = 0, **fields: Any) -> Perception:
    """The start of a map as blue sees it, with other `fields` of the state."""
    the_map = load_map(name)
    return Perception(the_map, replace(World(the_map).state(), tick=tick, **fields), 0)


def _selector(now: Perception) -> TaskSelector:
    selector = TaskSelector(now.map, Style())
    selector.observe_partner(now)
    return selector


def _ring(**fields: Any) -> Perception:
    """PriorityPick, a corridor all around: blue below on the left with item 3, red nearer to the goal on the right."""
    poses = np.array([[-0.5, -1.0, -np.pi / 2], [0.95, -0.8, 0.0]])
    items = _situation("PriorityPick").state.item_poses.copy()
    items[3, :2] = poses[0, :2] + [0.215, 0.0]
    return _situation("PriorityPick", **{"robot_poses": poses, "item_poses": items, **fields})


def test_who_holds_an_end_is_waited_for_and_not_taken_for_an_obstacle() -> None:
    held = np.array([-1, 0])
    selector = _selector(_situation("SingleRotation", held=held))
    assert not selector.partner_is_active(IDLE_AFTER) and not selector.partner_is_still(IDLE_AFTER)
    assert not selector.partner_is_still(WAITS_HOLDING_FOR - 1) and selector.partner_is_still(WAITS_HOLDING_FOR)
    assert _selector(_situation("SingleRotation")).partner_is_still(IDLE_AFTER)  # with empty hands


def test_two_who_stand_there_with_empty_hands_trust_each_other_again() -> None:
    selector = _selector(_situation("SingleRotation"))
    trusted = []
    for tick in range(1, IDLE_AFTER + 3):
        selector.observe_partner(_situation("SingleRotation", tick))
        trusted.append(selector.partner_is_active(tick))
    assert trusted == [True] * (IDLE_AFTER - 1) + [False] + [True] * 2


def test_beside_one_who_works_a_partner_who_stands_still_is_not_trusted_again() -> None:
    velocities = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    selector = _selector(_situation("SingleRotation", robot_velocities=velocities))
    for tick in range(1, 3 * IDLE_AFTER):
        selector.observe_partner(_situation("SingleRotation", tick, robot_velocities=velocities))
    assert not selector.partner_is_active(3 * IDLE_AFTER)


def test_in_a_lane_an_item_is_left_to_a_partner_nearer_to_the_goal() -> None:
    now = _ring(held=np.array([3, -1]))
    selector = _selector(now)
    assert selector.leaves_to_partner(now)
    later = _ring(tick=1)
    task = selector.next_task(later, None)
    assert task is not None and task.item != 3
    both = _ring(held=np.array([3, 4]))
    assert not _selector(both).leaves_to_partner(both)
    ahead = _ring(held=np.array([3, -1]), robot_poses=now.robots[::-1].copy())
    assert not _selector(ahead).leaves_to_partner(ahead)


def test_what_the_partner_has_just_put_down_near_by_is_taken_instead_of_something_far() -> None:
    start = _situation("PassOrSplit")
    poses, items = start.robots.copy(), start.state.item_poses.copy()
    poses[1] = poses[0] + [0.7, 0.0, 0.0]
    items[0, :2] = poses[0, :2] + [0.4, 0.0]
    before = _situation("PassOrSplit", robot_poses=poses, item_poses=items, held=np.array([-1, 0]))
    selector = _selector(before)
    first = selector.next_task(before, None)
    assert isinstance(first, Fetch) and first.item != 0
    after = _situation("PassOrSplit", 1, robot_poses=poses, item_poses=items)
    selector.observe_partner(after)
    second = selector.next_task(after, first)
    assert isinstance(second, Fetch) and second.item == 0


def test_one_stands_aside_until_the_partner_has_passed() -> None:
    items = _situation("PriorityPick").state.item_poses.copy()
    items[2, :2] = 1.07, 1.1

    def needed(red: float) -> bool:
        """Whether blue, below the goal, still stands aside at tick 44 for red who comes home at a height `red`."""
        poses = np.array([[1.05, 0.2, 0.0], [0.95, red, 0.0]])
        fields: dict[str, Any] = {"robot_poses": poses, "item_poses": items, "held": np.array([-1, 4])}
        selector = _selector(_situation("PriorityPick", **fields))
        return selector.partner_comes_until(25)(_situation("PriorityPick", 44, **fields))

    assert needed(-0.9) and not needed(0.45)


def test_who_finds_no_way_around_the_partner_stays_on_the_old_one() -> None:
    now = _ring(held=np.array([3, -1]), robot_poses=np.array([[-0.5, -1.0, -np.pi / 2], [0.2, -1.0, 0.0]]))
    items = now.state.item_poses.copy()
    items[1, :2] = -1.0, 0.6  # and something lies on the other way round
    now = replace(now, state=replace(now.state, item_poses=items))
    carry = Carry(now, 3, None, None)
    for _ in range(3):
        carry.step(now, no_collision_cost, THINK)
    plan = carry._carry_plan
    carry.go_around(now)
    for _ in range(3):
        carry.step(now, no_collision_cost, THINK)
    assert plan is not None and carry._carry_plan is plan


def test_where_delivered_things_shut_the_goal_it_goes_as_near_as_it_gets() -> None:
    items = _situation("PriorityPick").state.item_poses.copy()
    items[[0, 2, 4], :2] = (1.07, 1.1), (1.01, 0.96), (0.9, 0.83)  # as two experts once left them
    poses = np.array([[-0.6, -1.03, 0.0], [0.9, -0.2, 0.0]])
    now = _situation("PriorityPick", item_poses=items, robot_poses=poses)
    fetch = Fetch(now, 3, frozenset(), None)
    for _ in range(3):
        fetch.step(now, no_collision_cost, THINK)
    assert not fetch.infeasible and fetch.carry_plan is not None


def test_who_rests_where_the_partner_wants_to_go_makes_room_when_they_touch() -> None:
    items = _situation("PriorityPick").state.item_poses.copy()
    items[[0, 1, 2, 4], :2] = (1.06, 1.1), (0.86, 1.1), (0.97, 0.98), (0.91, 0.82)
    items[3, :2] = -0.53, -1.0
    poses = np.array([[-0.3, -1.02, 0.0], [-0.74, -0.98, -1.6]])
    selector = _selector(now := _situation("PriorityPick", item_poses=items, robot_poses=poses, held=np.array([-1, 3])))
    assert isinstance(selector.next_task(now, None), Aside)


def test_who_comes_first_to_a_heavy_item_leaves_the_other_one_room_to_come() -> None:
    items = _situation("AdaptiveAssist").state.item_poses.copy()
    items[5, :2] = -0.39, 0.12  # delivered; item 2 lies in the lane above, and red is nearer to it
    poses = np.array([[-0.44, 0.31, 3.9], [-0.12, 0.68, -0.4]])
    now = replace(_situation("AdaptiveAssist", item_poses=items, robot_poses=poses), seat=1)
    lift = Lift(now, 2, patience=100, failed_stances=frozenset())
    for _ in range(3):
        lift.step(now, no_collision_cost, THINK)
    poses, _ = stances(now.item(2), now.item_pose(2))
    mine = poses[lift.stance]
    ways = stance_costs(now, with_robot(now.space(also=(2,)), mine), now.partner, 2)
    opposite = [cost for pose, cost in zip(poses, ways, strict=True) if np.hypot(*(pose - mine)[:2]) > LEAST_DISTANCE]
    assert min(opposite) < UNREACHED


def test_a_partner_in_the_way_is_not_taken_for_an_arm_too_short() -> None:
    agent = ScriptedAgent()
    start = _situation("SingleRotation")
    blamed = {}
    for beside in (0.25, 0.6):  # units from blue, which stands beside the item, to red
        poses = start.item_pose(0) + np.array([[-0.4, 0.0, 0.0], [-0.4 - beside, 0.0, 0.0]])
        now = _situation("SingleRotation", robot_poses=poses)
        agent.reset(EpisodeInfo(now.map, 0, 0, 500))
        agent._task = lift = Lift(now, 0, patience=100, failed_stances=frozenset())
        for _ in range(3):
            lift.step(now, no_collision_cost, THINK)
        agent._unblock(now)
        blamed[beside] = 0 in agent._selector._failed_stances
    assert blamed == {0.25: False, 0.6: True}


def test_who_is_home_with_a_heavy_item_lets_go_soon_after_the_other_one_has() -> None:
    """At the start the other one is waited for, for all of one's patience."""
    patience = 5 * RELEASE_AT_HOME_AFTER
    for home, waits in ((True, RELEASE_AT_HOME_AFTER), (False, patience)):
        now = _situation("SingleRotation", held=np.array([0, -1]))
        if home:
            goal, items = now.map.goals[0], now.state.item_poses.copy()
            items[0, :2] = (goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2
            now = _situation("SingleRotation", held=np.array([0, -1]), item_poses=items)
        assert now.delivered[0] == home
        lift = Lift(now, 0, patience, frozenset())
        lift.step(now, no_collision_cost, THINK)  # sees where the other one is
        commands = [lift.step(now, no_collision_cost, THINK) for _ in range(waits + 1)]
        assert [command is not None and command.grasp for command in commands] == [False] * waits + [True]
        assert lift.waited_in_vain is not home  # it trusts the other one as before


def test_who_cannot_grab_beside_a_partner_that_holds_the_other_end_tries_another_stand() -> None:
    agent = ScriptedAgent()
    start = _situation("SingleRotation")
    poses = start.item_pose(0) + np.array([[-0.4, 0.0, 0.0], [-0.4, 0.25, 0.0]])
    now = _situation("SingleRotation", robot_poses=poses, held=np.array([-1, 0]))
    agent.reset(EpisodeInfo(now.map, 0, 0, 500))
    agent._task = lift = Lift(now, 0, patience=100, failed_stances=frozenset())
    for _ in range(3):
        lift.step(now, no_collision_cost, THINK)
    stance = lift.stance
    agent._unblock(now)
    assert agent._selector._failed_stances == {0: {stance}} and agent._task is None


def test_who_likes_far_things_keeps_to_the_one_it_has_chosen() -> None:
    """On the way to it another item becomes the farthest; an agent that switched then would never arrive."""
    start = _situation("CornerDecision")
    selector = TaskSelector(start.map, Style(far_first=True, heavy_first=False))
    selector.observe_partner(start)
    first = selector.next_task(start, None)
    poses = start.robots.copy()
    assert isinstance(first, Fetch)
    poses[0, :2] = 0.6 * start.item_pose(first.item)[:2]  # more than half way there
    later = _situation("CornerDecision", 40, robot_poses=poses)
    again = selector.next_task(later, None)
    fresh = TaskSelector(start.map, selector.style).next_task(later, None)
    assert isinstance(again, Fetch) and again.item == first.item
    assert isinstance(fresh, Fetch) and fresh.item != first.item


def test_patience_is_kept_while_the_partner_comes_back() -> None:
    """Near at first, then away for long, then on its way again: the last counts, not how near it was before."""

    def seen(gap: float) -> Perception:
        poses = _situation("SingleRotation").robots.copy()
        poses[1, :2] = _situation("SingleRotation").item_pose(0)[:2] + np.array([gap, 0.0])
        return _situation("SingleRotation", held=np.array([0, -1]), robot_poses=poses)

    lift = Lift(seen(0.5), 0, patience=60, failed_stances=frozenset())
    waited = []
    for gap in [0.5, *np.linspace(0.5, 1.7, 20), *[1.7] * 25, *np.linspace(1.7, 0.8, 15)]:
        lift.step(seen(float(gap)), no_collision_cost, THINK)
        waited.append(lift._waited)
    assert waited[45] >= 40 and waited[-1] < 10
    assert not lift.infeasible


def test_a_pair_that_gets_nowhere_lets_go_and_takes_other_sides() -> None:
    now = _situation("SingleRotation", held=np.array([0, 0]))
    selector = _selector(now)
    lift = Lift(now, 0, patience=60, failed_stances=frozenset())
    commands = [lift.step(now, no_collision_cost, THINK) for _ in range(PAIR_RELEASE_AFTER + 4)]  # nothing moves
    assert commands[-1] is not None and commands[-1].grasp
    assert not any(command is not None and command.grasp for command in commands[:PAIR_RELEASE_AFTER])
    selector.ended(now, lift)
    poses, _ = stances(now.item(0), now.item_pose(0))
    off = np.abs((poses[:, 2] - now.pose[2] + np.pi) % (2 * np.pi) - np.pi)
    assert selector._failed_stances[0] == set(np.flatnonzero(off < np.pi / 3 - 1e-6).tolist())


def test_stands_with_little_room_beside_a_heavy_item_are_dear() -> None:
    """Items 3 and 5 of CornerDecision lie on both sides of item 4: the stands between are dear, the others are not."""
    now = _situation("CornerDecision")
    poses, _ = stances(now.item(4), now.item_pose(4))
    prices = tight_stance_costs(now, now.space((4,)), 4)
    above = np.argmin(np.abs(poses[:, 2] - np.pi))  # looks down at the item
    beside = np.argmin(np.abs(poses[:, 2] - np.pi / 2))  # between items 3 and 4
    assert prices[above] == 0.0 and prices[beside] > 0.0
