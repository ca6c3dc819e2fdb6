"""The scripted agent comes when its partner asks for help, and plays as ever when nobody does."""

import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from movingout.agents.action_chunk import world_action
from movingout.agents.base import EpisodeInfo
from movingout.agents.observation.seat_observation import observe
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.help_request import HelpRequest
from movingout.agents.scripted.navigation.motion_choice import no_collision_cost
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.task_choice import TaskSelector
from movingout.agents.scripted.tasks.wait import BESIDE, ComeTo
from movingout.maps import load_map
from movingout.recordings.versions import why_not_exact
from movingout.world import World
from movingout.world.ping import OWN_PLACE, HelpPing, said, shown
from movingout.world.state import WorldState
from tests.agents.scripted.golden_actions import FILE, MAPS, replayed

BLUE, RED = 0, 1
REST = (0.0, 0.0, 0.0)


def play(map_name: str, ticks: int, pings: dict[int, int] | None = None, pinger: int = BLUE) -> list[WorldState]:
    """States of red scripted beside a blue who stays; `pings`: by tick the item that the `pinger` points at."""
    spec = load_map(map_name)
    world, agent = World(spec), ScriptedAgent()
    agent.reset(EpisodeInfo(spec, RED, 0, 500))
    told: list[HelpPing] = []
    states = [world.state()]
    for tick in range(ticks):
        if tick in (pings or {}):
            told.append(said(states[-1], pinger, (pings or {})[tick]))
        seen = observe(spec, states[-1], RED, pings=shown(told, tick))
        world.step(np.array([REST, world_action(agent.act(seen)[0])]))
        states.append(world.state())
    return states


@pytest.mark.parametrize("map_name", MAPS)
def test_without_a_ping_it_plays_to_the_bit_as_recorded_before_there_were_any(map_name: str) -> None:
    with np.load(FILE) as golden:
        recorded, made_with = golden[map_name], json.loads(str(golden["versions"]))
    answered = replayed(map_name, recorded)
    if why_not_exact(made_with):
        np.testing.assert_allclose(answered, recorded, atol=1e-9)
    else:
        np.testing.assert_array_equal(answered, recorded)


def test_it_plays_to_the_bit_alike_on_a_processor_without_avx_512() -> None:
    """With the instructions switched off in NumPy: where the processor has none, both are without."""
    program = "import sys; from tests.agents.scripted.golden_actions import replayed; "
    program += "sys.stdout.buffer.write(replayed('AdaptiveAssist').tobytes())"
    played = [
        subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, env=os.environ | switches)
        for switches in ({}, {"NPY_DISABLE_CPU_FEATURES": "X86_V4"})
    ]
    assert len(played[0].stdout) > 1000
    assert played[0].stdout == played[1].stdout


@pytest.mark.parametrize("item", range(4))
def test_it_takes_hold_of_the_heavy_item_that_the_partner_points_at(item: int) -> None:
    assert play("FourCorners", 80, {5: item})[-1].held[RED] == item


def test_a_heavy_item_that_it_holds_alone_is_let_go_for_the_one_that_is_pointed_at() -> None:
    before = play("FourCorners", 60)
    held = int(before[-1].held[RED])
    assert held >= 0
    other = (held + 1) % 4
    after = play("FourCorners", 110, {60: other})
    assert before[-1].held[RED] == held and after[62].held[RED] == -1
    assert after[-1].held[RED] == other


def test_at_the_own_place_of_the_partner_it_comes_and_waits_beside_it() -> None:
    start = play("AdaptiveAssist", 0)[0].robot_poses[BLUE, :2]

    def nearest(pings: dict[int, int]) -> float:
        return min(math.dist(state.robot_poses[RED, :2], start) for state in play("AdaptiveAssist", 60, pings))

    assert nearest({0: OWN_PLACE}) < BESIDE < nearest({})


def test_where_it_cannot_come_it_goes_on_with_its_own_work() -> None:
    spec = load_map("PriorityPick")  # items block both ways to the partner
    state = World(spec).state()
    now, selector = Perception(spec, state, RED), TaskSelector(spec, Style())
    selector.observe_partner(now)
    selector.hear(now, (said(state, BLUE, OWN_PLACE),))
    task = selector.next_task(now, None)
    assert isinstance(task, ComeTo) and task.step(now, no_collision_cost, 1) is None
    selector.ended(now, task)
    assert not isinstance(selector.next_task(now, None), ComeTo)


@pytest.mark.parametrize(("x", "y", "meant"), [(-0.4, 0.4, 0), (0.4, -0.4, 1), (-1.0, -1.0, OWN_PLACE)])
def test_at_a_place_beside_a_heavy_item_that_item_is_meant(x: float, y: float, meant: int) -> None:
    spec = load_map("TopBottomPriority")  # a large item above, a middle one below
    now, request = Perception(spec, World(spec).state(), RED), HelpRequest()
    assert request.hear(now, (HelpPing(1, BLUE, OWN_PLACE, x, y),)) and request.item == meant
    assert not request.hear(now, (HelpPing(1, BLUE, OWN_PLACE, x, y),)), "each ping is heard once"


def test_a_small_item_that_it_carries_is_brought_home_first() -> None:
    plain = play("DistancePriority", 500)
    first = next(state.tick for state in plain if state.held[RED] >= 2)
    states = play("DistancePriority", first + 200, {first: 0})
    carried = int(states[first].held[RED])
    world = World(load_map("DistancePriority"))
    released = next(state for state in states[first:] if state.held[RED] != carried)
    assert world.map.items[carried].size == "small"
    assert any(state.held[RED] == 0 for state in states[released.tick :])


def test_its_own_pings_mean_nothing_to_it() -> None:
    plain = play("FourCorners", 60)
    pinged = play("FourCorners", 60, {5: 3, 20: -1}, pinger=RED)
    assert all(np.array_equal(one.robot_poses, other.robot_poses) for one, other in zip(plain, pinged, strict=True))
