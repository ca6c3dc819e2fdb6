"""The expert with partners of another make: it gives in, takes hold differently, uses its time, and leaves no jam."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from movingout.agents.action_chunk import world_action
from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.handover_trust import CARRIES_ALONE_FOR, LEFT_LYING_FOR, HandoverTrust
from movingout.agents.scripted.jam import JAMMED_AFTER, GiveRoom
from movingout.agents.scripted.navigation.geometry import heading_of
from movingout.agents.scripted.navigation.grasp_stance import reaching_heading, stances, within_reach
from movingout.agents.scripted.navigation.motion_choice import no_collision_cost
from movingout.agents.scripted.partner_intent import PartnerIntent
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.task_choice import INFEASIBLE_FOR, TaskSelector
from movingout.agents.scripted.tasks.fetch import Fetch
from movingout.agents.scripted.tasks.joint_carry import FUTILE_AFTER, STUCK_AFTER
from movingout.agents.scripted.tasks.lift import WAITS_UNSEEN, YIELDS_AFTER, Lift
from movingout.maps import load_map
from movingout.world import World
from movingout.world.state import WorldState
from tests.agents.scripted.arena import (
    BLUE,
    RED,
    Action,
    goal_middle,
    play_with,
    pulls_to,
    shared_item_map,
)

THINK = 1000  # slices: to the end
_NEARER = 0.35  # of the way from the middle to the opposite goal


def _scene(name: str, **fields: Any) -> WorldState:
    return replace(start_state(load_map(name)), **fields)


def _seen(intent: PartnerIntent, name: str, state: WorldState, seat: int = RED) -> Perception:
    intent.observe(state)
    return Perception(load_map(name), state, seat, intent=intent)


# ---- giving in -----------------------------------------------------------------------------------------------------


def _quarrel(agent: ScriptedAgent, goal: int) -> list[float]:
    """How far the item is from a goal to which blue pulls straight; another goal, to which red plans, is nearer."""
    away = np.array(goal_middle(load_map("FourCorners"), goal))
    the_map = shared_item_map(*(-_NEARER * away).tolist())
    states = play_with(agent, the_map, pulls_to((float(away[0]), float(away[1]))), 100)
    return [float(np.hypot(*(state.item_poses[0, :2] - away))) for state in states]


@pytest.mark.parametrize("goal", range(4))
def test_it_gives_in_within_a_second_when_the_partner_pulls_to_another_goal(goal: int) -> None:
    gaps = _quarrel(ScriptedAgent(slices=THINK), goal)
    assert all(gaps[tick] - gaps[tick + 5] > 0.03 for tick in (11, 16, 21)[: len(gaps) // 10])  # its way from then on
    assert gaps[-1] < 0.45 and len(gaps) < 50


@pytest.mark.parametrize("goal", range(4))
def test_without_giving_in_such_a_quarrel_lasts(goal: int) -> None:
    gaps = _quarrel(ScriptedAgent(slices=THINK, adapts=False), goal)
    assert len(gaps) > 50


def test_it_leads_on_when_the_partner_only_stands_there() -> None:
    the_map = shared_item_map()

    def stands(state: WorldState) -> Action:
        return 0.0, float(state.robot_poses[BLUE, 2]), float(state.tick == 0)

    assert len(play_with(ScriptedAgent(slices=THINK), the_map, stands, 150)) < 150


def test_of_two_with_a_heavy_item_each_red_comes_before_blue_would() -> None:
    let_go = {}
    for seat in (BLUE, RED):
        intent = PartnerIntent(load_map("FourCorners"), seat)
        lift: Lift | None = None
        for tick in range(30):
            state = _scene("FourCorners", tick=tick, held=np.array([0, 1] if seat == BLUE else [1, 0]))
            now = _seen(intent, "FourCorners", state, seat)
            lift = lift or Lift(now, 0, 60, frozenset())
            command = lift.step(now, no_collision_cost, THINK)
            if command is not None and command.grasp:
                let_go[seat] = tick
                break
    assert let_go == {BLUE: YIELDS_AFTER[BLUE], RED: YIELDS_AFTER[RED]}


# ---- taking hold ---------------------------------------------------------------------------------------------------


def test_both_ends_are_taken_differently_when_the_item_has_not_moved_for_long() -> None:
    intent = PartnerIntent(load_map("SingleRotation"), RED)
    lift: Lift | None = None
    pressed = -1
    for tick in range(2 * FUTILE_AFTER):
        now = _seen(intent, "SingleRotation", _scene("SingleRotation", tick=tick, held=np.array([0, 0])))
        lift = lift or Lift(now, 0, 60, frozenset())
        command = lift.step(now, no_collision_cost, THINK)
        assert command is not None
        intent.commanded(command)
        if command.grasp:
            pressed = tick
            break
    assert lift is not None and FUTILE_AFTER <= pressed <= FUTILE_AFTER + 3 and lift.given_up is not None
    selector = TaskSelector(load_map("SingleRotation"), Style())
    selector.ended(now, lift)
    again = selector._lift(now, 0)
    assert again._failed_stances  # it will stand elsewhere


@pytest.mark.parametrize(("reach", "is_left"), [(0.1, True), (0.4, False)])
def test_a_heavy_item_that_only_goes_to_and_fro_is_left_for_small_ones(reach: float, is_left: bool) -> None:
    the_map = load_map("CornerDecision")
    intent, selector, lift = PartnerIntent(the_map, RED), TaskSelector(the_map, Style()), None
    start = _scene("CornerDecision", held=np.array([1, 1]))
    pressed = -1
    for tick in range(STUCK_AFTER + 5):
        moved = np.zeros_like(start.item_poses)
        moved[1, 0] = reach * math.sin(tick * 0.4)
        robots = start.item_poses[[1, 1]] + moved[[1, 1]] + np.array([[0.3, 0.0, 1.57], [-0.3, 0.0, -1.57]])
        now = _seen(
            intent,
            "CornerDecision",
            replace(start, tick=tick, item_poses=start.item_poses + moved, robot_poses=robots),
        )
        lift = lift or Lift(now, 1, 60, frozenset())
        command = lift.step(now, no_collision_cost, 1)
        assert command is not None
        intent.commanded(command)
        if command.grasp:
            pressed = tick
            break
    assert lift is not None and lift.got_stuck is is_left and (pressed >= STUCK_AFTER) is is_left
    if not is_left:
        return
    selector.ended(now, lift)
    for free in (replace(now.state, held=np.array([1, -1])), replace(now.state, held=np.array([-1, -1]))):
        seen = _seen(intent, "CornerDecision", replace(free, tick=now.tick + INFEASIBLE_FOR + 1))
        task = selector.next_task(seen, None)
        assert isinstance(task, Fetch) and not seen.is_heavy(task.item)  # though the partner holds the heavy one


@pytest.mark.parametrize("stance", [0, 8, 16, 24])
def test_the_other_end_of_what_the_partner_holds_is_taken_without_hovering(stance: int) -> None:
    """Once it hovered at the corner of the rectangle for more than five seconds without grabbing."""
    the_map = load_map("SingleRotation")
    item = the_map.items[0]
    x, y, angle = stances(item, np.array([item.pose.x, item.pose.y, item.pose.angle]))[0][stance].tolist()
    held_map = replace(the_map, robots=(replace(the_map.robots[0], x=x, y=y, angle=angle), the_map.robots[1]))

    def holds(state: WorldState) -> Action:
        return 0.0, angle, float(state.tick == 0)

    states = play_with(ScriptedAgent(), held_map, holds, 60, grabs_at_once=False)
    beside = [float(np.hypot(*(state.robot_poses[RED] - state.item_poses[0])[:2])) < 0.45 for state in states]
    taken = next(tick for tick, state in enumerate(states) if state.held[RED] >= 0)
    assert taken < 40 and sum(beside[:taken]) < 25


def test_at_a_corner_it_turns_until_its_gripper_reaches() -> None:
    item = load_map("SingleRotation").items[0]
    item_pose, robot = np.array([-0.6, -0.7, 0.0]), np.array([-0.83, -0.9, -0.86])
    assert not within_reach(item, item_pose, robot)
    turned = reaching_heading(item, item_pose, robot)
    assert turned is not None and within_reach(item, item_pose, np.array([*robot[:2], turned]))
    assert reaching_heading(item, item_pose, np.array([0.5, 0.5, 0.0])) is None


# ---- using time ----------------------------------------------------------------------------------------------------


def _held_for(name: str, item: int, walks_to_it: bool) -> int:
    """For how many ticks red holds a heavy item while blue comes, or stays where it is."""
    intent = PartnerIntent(load_map(name), RED)
    start, lift = _scene(name), None
    for tick in range(80):
        poses = start.robot_poses.copy()
        if walks_to_it:
            away = start.item_poses[item, :2] - poses[BLUE, :2]
            poses[BLUE, :2] += 0.012 * tick * away / np.hypot(*away)
        now = _seen(intent, name, _scene(name, tick=tick, held=np.array([-1, item]), robot_poses=poses))
        lift = lift or Lift(now, item, 60, frozenset())
        command = lift.step(now, no_collision_cost, THINK)
        if command is not None and command.grasp:
            return tick
    return 80


def test_it_does_not_wait_for_who_does_not_come_when_there_are_small_items_to_fetch() -> None:
    assert load_map("CornerDecision").items[1].size == "middle"
    assert _held_for("CornerDecision", 1, walks_to_it=False) == WAITS_UNSEEN
    assert _held_for("FourCorners", 0, walks_to_it=False) > 2 * WAITS_UNSEEN  # where there is nothing else to do


def test_it_goes_on_holding_for_who_comes() -> None:
    assert _held_for("CornerDecision", 1, walks_to_it=True) > WAITS_UNSEEN + 10


def test_it_goes_to_the_heavy_item_and_leaves_the_small_one_to_which_the_partner_goes() -> None:
    for name, item, kind in (("FourCorners", 2, Lift), ("PassOrSplit", 1, Fetch)):
        the_map = load_map(name)
        intent, state = PartnerIntent(the_map, RED), _scene(name)
        start = state.robot_poses[BLUE, :2].copy()
        for tick in range(14):
            poses = state.robot_poses.copy()
            poses[BLUE, :2] = start + 0.4 * tick / 13 * (state.item_poses[item, :2] - start)
            now = _seen(intent, name, replace(state, tick=tick, robot_poses=poses))
        selector = TaskSelector(the_map, Style())
        selector.observe_partner(now)
        task = selector.next_task(now, None)
        assert isinstance(task, kind)
        assert (task.item == item) is (kind is Lift)


def test_in_a_lane_it_stops_handing_over_when_nobody_comes_for_it() -> None:
    intent, trust = PartnerIntent(load_map("HandOff"), RED), HandoverTrust()
    lost = []
    for tick in range(LEFT_LYING_FOR + 3):
        now = _seen(intent, "HandOff", _scene("HandOff", tick=tick))
        lost.append(trust.nobody_comes(now, [0]))
    assert lost == [False] * (LEFT_LYING_FOR + 1) + [True] * 2
    trust.is_lost(now)
    assert not trust.lasts(now.tick + 1) and trust.lasts(now.tick + CARRIES_ALONE_FOR)
    assert not trust.nobody_comes(replace(now, intent=None), [0])


def test_in_a_lane_it_stops_waiting_for_who_brings_nothing() -> None:
    intent, trust = PartnerIntent(load_map("HandOff"), RED), HandoverTrust()
    lost = [
        trust.nobody_brings(_seen(intent, "HandOff", _scene("HandOff", tick=tick)))
        for tick in range(LEFT_LYING_FOR + 3)
    ]
    assert lost[-1] and not lost[LEFT_LYING_FOR]
    carrying = _scene("HandOff", tick=LEFT_LYING_FOR + 3, held=np.array([0, -1]))
    assert not trust.nobody_brings(_seen(intent, "HandOff", carrying))


# ---- jams ----------------------------------------------------------------------------------------------------------


def _jammed(item_beside: bool) -> ScriptedAgent:
    """Red after pushing against blue for long; with or without the item that it wants at hand."""
    the_map = load_map("PassOrSplit")
    agent, state = ScriptedAgent(slices=THINK), start_state(the_map)
    agent.reset(EpisodeInfo(the_map, RED, 0, 500))
    red = state.item_poses[0] + np.array([-0.25 if item_beside else -0.9, 0.0, 0.0])
    poses = np.stack([red + np.array([-0.1, -0.23, 0.0]), red])
    for tick in range(JAMMED_AFTER + 2):
        now = replace(state, tick=tick, robot_poses=poses)
        if tick == 1:
            agent._task = Fetch(Perception(the_map, now, RED, intent=agent._intent), 0, frozenset(), None)
        agent.act(observe(the_map, now, RED))
    return agent


def test_it_gives_room_when_both_push_in_vain() -> None:
    agent = _jammed(item_beside=False)
    assert isinstance(agent._task, GiveRoom)
    the_map, state = load_map("Simple"), start_state(load_map("Simple"))
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.25, 0.0]])
    now = Perception(the_map, replace(state, robot_poses=poses), RED)
    command = GiveRoom(now).step(now, no_collision_cost, THINK)
    assert command is not None
    assert np.sign(command.distance) * np.cos(command.heading) > 0.5  # away from blue, which is below


def test_an_item_at_hand_is_taken_rather_than_given_way_for() -> None:
    agent = _jammed(item_beside=True)
    assert isinstance(agent._task, Fetch)
    gap = agent._task._approach.target[:2] - start_state(load_map("PassOrSplit")).item_poses[0, :2]
    assert float(np.hypot(*gap)) == pytest.approx(0.25) and heading_of(*(-gap).tolist()) < 0


def test_who_is_walled_in_by_a_small_delivered_item_moves_it_again() -> None:
    the_map = load_map("HandOff")
    robots = np.array([[-0.9, 1.02, 0.0], [0.121, -1.08, 0.282]])  # red at the dead end of the lane, behind item 2
    items = np.array([[-1.1, 1.1, 0.93], [-1.1, 0.95, 0.85], [0.052, -0.844, 1.955], [-0.9, 1.1, 0.75]])
    world = World.from_state(the_map, _scene("HandOff", robot_poses=robots, item_poses=items))
    agent = ScriptedAgent()
    agent.reset(EpisodeInfo(the_map, RED, 0, 500))
    farthest = -1.0
    for _ in range(200):
        away = 0.0, math.pi * (world.tick % 20 < 10), 0.0  # blue is busy where it is
        world.step(np.array([away, world_action(agent.act(observe(the_map, world.state(), RED))[0])]))
        farthest = max(farthest, float(world.state().robot_poses[RED, 1]))
    assert farthest > items[2, 1] + 0.2


def test_who_is_walled_in_moves_a_small_item_though_the_partner_holds_a_heavy_one() -> None:
    """Once it stood there for half the round, while the partner waited for its help."""
    the_map = load_map("AdaptiveAssist")
    robots = np.array([[-0.599, 0.28, 4.797], [-0.279, -0.791, -4.496]])  # the wall between them is open at the goal
    small, heavy = [[0.38, -0.133, -2.461], [0.052, -0.284, 4.946], [-0.199, 0.24, 5.863]], [0.056, 0.241, 0.922]
    items = np.array([small[0], [-0.498, -0.838, 0.44], heavy, small[1], [0.45, -0.95, 0.667], small[2]])
    state = _scene("AdaptiveAssist", robot_poses=robots, item_poses=items, held=np.array([-1, 1]))
    world, agent = World.from_state(the_map, state), ScriptedAgent()
    agent.reset(EpisodeInfo(the_map, BLUE, 0, 500))
    for _ in range(220):
        waits = 0.0, float(world.state().robot_poses[RED, 2]), 0.0
        world.step(np.array([world_action(agent.act(observe(the_map, world.state(), BLUE))[0]), waits]))
        if world.state().held[BLUE] == 1:
            break
    assert world.state().held.tolist() == [1, 1]


# ---- the whole -----------------------------------------------------------------------------------------------------


def test_the_old_expert_can_still_be_asked_for() -> None:
    agent = load_agent("scripted:adapts=0,patience=25,yields=1")
    assert isinstance(agent, ScriptedAgent) and not agent.adapts and agent.yields
