"""Habits of a plan: each changes what is done, in the way it says, and a pair with it still gets everything home."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.scripted import ScriptedAgent
from movingout.agents.scripted.avoidance import side_costs
from movingout.agents.scripted.navigation.grasp_stance import HEADINGS
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.handover_lanes import handover_lane
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.task_choice import FETCHED_WITHIN, TaskSelector
from movingout.agents.scripted.tasks.fetch import Fetch
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.maps import load_map
from movingout.world import World
from movingout.world.scoring import delivered_items


def _situation(name: str, seat: int = 0, tick: int = 0, **fields: Any) -> Perception:
    """The start of a map as a seat sees it, with other `fields` of the state."""
    the_map = load_map(name)
    return Perception(the_map, replace(World(the_map).state(), tick=tick, **fields), seat)


def _chosen(now: Perception, task: Task | None = None, **habits: Any) -> Task | None:
    selector = TaskSelector(now.map, Style(**habits))
    selector.observe_partner(now)
    return selector.next_task(now, task)


def _first_grasp(name: str, **habits: Any) -> tuple[int, float]:
    """Which item blue takes first with red idle, and the heading in which it looks then."""
    for step in rollout(load_map(name), (ScriptedAgent(**habits), load_agent("idle")), 0, 100):
        if step.after.held[0] >= 0:
            return int(step.after.held[0]), float(step.after.robot_poses[0, 2])
    raise AssertionError("nothing taken")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("role=boss", "role must be one of equal, leader, follower, not 'boss'"),
        ("help_after=90", "help_after must lie between 0 and 60, not 90"),
        ("help_after=late", "help_after must lie between 0 and 60, not late"),
        ("handover=0", "handover must lie between 0.2 and 0.8, not 0"),
        ("side=left", "side must lie between -1.0 and 1.0, not left"),
        ("stick=8", "no habit 'stick' of a plan; known: heavy_first"),
    ],
)
def test_an_unknown_habit_is_refused_with_the_known_ones(options: str, sentence: str) -> None:
    with pytest.raises(AgentError, match="style: ") as raised:
        load_agent(f"scripted:{options}")
    assert sentence in str(raised.value)


def test_a_leader_begins_what_is_near_to_itself_and_others_what_is_near_to_both() -> None:
    now = _situation("FourCorners")
    led, shared = _chosen(now, role="leader"), _chosen(now)
    assert isinstance(led, Lift) and isinstance(shared, Lift)

    def gap(item: int) -> float:
        return math.dist(now.item_pose(item)[:2], now.pose[:2])

    assert led.item != shared.item and gap(led.item) == min(map(gap, now.waiting))


def test_a_follower_begins_what_is_near_to_its_partner() -> None:
    now = _situation("CornerDecision")
    followed, shared = _chosen(now, role="follower"), _chosen(now)
    assert isinstance(followed, Lift) and isinstance(shared, Lift)
    heavies = [item for item in now.waiting if now.is_heavy(item)]
    assert followed.item == min(heavies, key=lambda item: math.dist(now.item_pose(item)[:2], now.partner[:2]))
    assert followed.item != shared.item


def test_a_follower_leaves_to_its_partner_what_is_near_to_that_one() -> None:
    now = _situation("DistancePriority")
    smalls = [item for item in now.waiting if not now.is_heavy(item)]
    assert len(smalls) == 2
    beside = now.item_pose(smalls[0]) + np.array([0.3, 0.0, 0.0])
    now = _situation("DistancePriority", robot_poses=np.stack([beside, beside + np.array([0.0, 0.3, 0.0])]))
    items = {role: _chosen(now, role=role, heavy_first=False) for role in ("leader", "follower")}
    assert {role: task.item for role, task in items.items() if task} == {
        "leader": smalls[0],
        "follower": smalls[1],
    }


def test_a_follower_drops_its_own_plan_when_the_partner_stands_at_another_heavy_item() -> None:
    now = _situation("FourCorners")
    task = _chosen(now)
    assert isinstance(task, Lift)
    other = next(item for item in now.waiting if item != task.item)
    there = now.item_pose(other) + np.array([0.3, 0.0, 0.0])
    later = _situation("FourCorners", robot_poses=np.stack([now.pose, there]))
    kept, changed = _chosen(later, task), _chosen(later, task, role="follower")
    assert kept is task and changed is not None and changed.item == other


def test_who_helps_late_goes_on_for_so_many_ticks_before_it_comes() -> None:
    now = _situation("CornerDecision", held=np.array([-1, 1]))
    assert now.is_heavy(1)
    at_once = _chosen(now)
    assert isinstance(at_once, Lift) and at_once.item == 1
    late = TaskSelector(now.map, Style(help_after=30))
    for tick, comes in ((0, False), (29, False), (30, True)):
        later = _situation("CornerDecision", tick=tick, held=np.array([-1, 1]))
        late.observe_partner(later)
        task = late.next_task(later, None)
        assert isinstance(task, Lift if comes else Fetch), f"tick {tick}"


def test_who_has_nothing_of_its_own_to_do_helps_at_once() -> None:
    task = _chosen(_situation("FourCorners", held=np.array([-1, 0])), help_after=30)
    assert isinstance(task, Lift) and task.item == 0


def test_things_change_hands_where_the_player_likes_it() -> None:
    the_map = load_map("HandOff")
    near, usual, far = (handover_lane(the_map, share).handover for share in (0.25, 0.5, 0.75))
    assert near == pytest.approx(usual / 2) and far == pytest.approx(usual * 1.5)


def test_an_item_handed_over_far_from_the_goal_is_carried_nearer_when_the_partner_does_not_come() -> None:
    now = _situation("HandOff")
    places = now.state.item_poses.copy()
    plan = handover_lane(now.map, 0.75)
    row, column = np.unravel_index(int(np.argmin(np.abs(plan.cost_to_goal - plan.handover))), plan.cost_to_goal.shape)
    places[0, :2] = np.linspace(-1.2, 1.2, plan.cost_to_goal.shape[0])[[column, row]]
    inner = 0 if plan.left(now.robots[0]) > plan.left(now.robots[1]) else 1
    selector = TaskSelector(now.map, Style(handover=0.75))
    items = []
    for tick in (0, FETCHED_WITHIN, FETCHED_WITHIN + 1, FETCHED_WITHIN + 2):
        later = _situation("HandOff", inner, tick, item_poses=places)
        selector.observe_partner(later)
        task = selector.next_task(later, None)
        items.append(task.handover.handover if isinstance(task, Fetch) and task.handover else None)
    usual = handover_lane(now.map, 0.5).handover
    assert items == [None, None, usual, usual]  # first it looks whether the partner comes


def test_the_side_from_which_one_grabs_costs_nothing_and_the_opposite_one_most() -> None:
    now = _situation("AdaptiveAssist")
    behind, ahead = np.array(side_costs(now, 5, 1.0)), np.array(side_costs(now, 5, -1.0))
    turned = HEADINGS[int(behind.argmin())] - HEADINGS[int(ahead.argmin())]
    assert abs(turned) == pytest.approx(math.pi) and behind.min() == pytest.approx(0.0, abs=1.0)
    assert behind.argmax() == ahead.argmin() and not any(side_costs(now, 5, 0.0))


def test_who_pushes_takes_an_item_from_another_side_than_who_pulls() -> None:
    (item, pushing), (same, pulling) = (_first_grasp("CornerDecision", side=side) for side in (1.0, -1.0))
    assert item == same and abs(math.remainder(pushing - pulling, 2 * math.pi)) > 1.0


@pytest.mark.parametrize("habits", ["role=leader", "role=follower", "help_after=30", "side=1.0", "side=-1.0"])
def test_a_pair_with_a_habit_gets_a_heavy_item_round_the_corner(habits: str) -> None:
    the_map = load_map("SingleRotation")
    *_, last = rollout(the_map, (load_agent(f"scripted:{habits}"), load_agent(f"scripted:{habits}")), 0, 400)
    assert delivered_items(the_map, last.after.item_poses).all()


@pytest.mark.parametrize("pair", [(0.25, 0.5), (0.75, 0.5)])
def test_two_who_would_hand_over_in_different_places_come_to_terms(pair: tuple[float, float]) -> None:
    the_map = load_map("HandOff")
    blue, red = (load_agent(f"scripted:handover={share}") for share in pair)
    *_, last = rollout(the_map, (blue, red), 0, 500)
    assert delivered_items(the_map, last.after.item_poses).all()


class HoldsOn:
    """A person who takes an item and then waits for help."""

    def __init__(self) -> None:
        self._drives, self._waits = load_agent("scripted"), load_agent("idle")

    def reset(self, episode: EpisodeInfo) -> None:
        self._drives.reset(episode)
        self._waits.reset(episode)

    def act(self, observation: Observation) -> ActionChunk:
        holds = observation.state.held[observation.seat] >= 0
        return (self._waits if holds else self._drives).act(observation)


@pytest.mark.parametrize("name", ["SingleRotation", "SequentialRotations", "LeftRight", "FourCorners"])
@pytest.mark.parametrize("seat", [0, 1])
def test_who_holds_a_heavy_item_and_waits_is_helped_within_two_seconds(name: str, seat: int) -> None:
    taken = None
    agents = (HoldsOn(), load_agent("scripted"))
    for tick, step in enumerate(rollout(load_map(name), agents if seat == 0 else agents[::-1], 0, 300)):
        held = step.after.held
        if taken is None and held[seat] >= 0:
            taken = tick
        if taken is not None and held[0] == held[1]:
            assert tick - taken <= 20
            return
    raise AssertionError(f"taken at {taken}, and nobody came")
