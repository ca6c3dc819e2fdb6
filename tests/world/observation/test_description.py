"""A state in words and as JSON: who is where, who holds what, and what is left."""

import json
import re
from dataclasses import replace

from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.maps.spec import ARENA_HALF
from movingout.world.observation.description import Description, described

MAP = load_map("HandOff")


def test_the_text_names_everything_that_a_person_sees() -> None:
    state = start_state(MAP)
    state.held[1] = 0
    lines = str(observe(MAP, state, 1).describe()).splitlines()
    assert lines[0] == f"HandOff, 0.0 s. You are red; 0 of {len(MAP.items)} items are delivered."
    assert lines[1].startswith("You are at (") and lines[1].endswith("and hold item 0.")
    assert lines[2].startswith("Your partner is at (") and lines[2].endswith("and holds nothing.")
    assert lines[3].startswith("Item 0: ") and "held by you" in lines[3]
    assert len(lines) == 5 + len(MAP.items) and lines[-2].startswith("Goals (left, bottom, right, top): (")
    assert lines[-1].startswith("Walls (left, bottom, right, top): (")
    assert lines[-1].count("(") == 1 + len(MAP.walls)


def test_a_map_without_walls_has_no_line_of_them() -> None:
    assert "Walls" not in str(described(replace(MAP, walls=()), start_state(MAP), 0))


def test_nothing_lies_at_minus_zero() -> None:
    state = start_state(MAP)
    state.robot_poses[:, :2] = state.item_poses[:, :2] = -0.001
    told = observe(MAP, state, 0).describe()
    assert "You are at (0.0, 0.0)" in str(told)
    assert "-0.0" not in re.findall(r"-?\d+\.\d+", str(told))


def test_the_json_is_plain_and_seen_from_the_seat() -> None:
    state = start_state(MAP)
    state.held[:] = 2
    blue, red = (observe(MAP, state, seat).describe().to_json() for seat in (0, 1))
    assert json.loads(json.dumps(blue)) == blue
    assert (blue["you"], blue["partner"]) == (red["partner"], red["you"])
    assert blue["items"][2]["held_by"] == ["you", "your partner"]
    assert all(item["way_to_goal"] > 0 and not item["delivered"] for item in blue["items"])
    assert len(blue["goals"]) == len(MAP.goals) and len(blue["walls"]) == len(MAP.walls)


def test_lengths_are_those_of_the_arena_that_it_tells_of() -> None:
    assert f"goes from -{ARENA_HALF} to {ARENA_HALF} " in " ".join(str(Description.__doc__).split())
