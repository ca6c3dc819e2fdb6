"""What a robot's motion says of the command that drives it, and guesses that begin with that."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.partner_motion import KEPT, MotionBassAgent, command_seen
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.maps import load_map, map_from_json, map_to_json
from movingout.world import World

SIMPLE = load_map("Simple")
_ROBOTS = {"blue": {"x": -0.6, "y": -1.0, "angle": 0.0}, "red": {"x": 0.0, "y": 0.3, "angle": 0.0}}
OPEN = map_from_json(map_to_json(SIMPLE) | {"robots": _ROBOTS})  # nothing is in red's way


@pytest.mark.parametrize(("distance", "heading"), [(0.9, 0.0), (0.5, 0.6), (0.9, -1.2), (1.0, 0.8), (0.9, 2.5)])
def test_the_command_of_a_robot_that_drives_is_seen(distance: float, heading: float) -> None:
    world = World(OPEN, record_sub_poses=False)
    for _ in range(5):
        world.step([[0.0, 0.0, 0.0], [distance, heading, 0.0]])
        seen = command_seen(OPEN, world.state(), 1)
        assert seen is not None
        assert np.allclose(seen, [distance, np.cos(heading), np.sin(heading)], atol=0.02)


def test_who_stands_is_seen_to_stand() -> None:
    seen = command_seen(SIMPLE, World(SIMPLE, record_sub_poses=False).state(), 1)
    assert seen is not None and seen[0] == 0.0


def test_of_two_at_one_item_neither_command_is_seen() -> None:
    state = replace(World(SIMPLE, record_sub_poses=False).state(), held=np.array([0, 0]))
    assert command_seen(SIMPLE, state, 1) is None


def test_a_guess_begins_with_what_is_seen_and_ends_near_the_policys() -> None:
    agent = load_agent("bass@any:partner=motion")
    assert isinstance(agent, MotionBassAgent)
    agent.reset(EpisodeInfo(SIMPLE, 0, 0, 500))
    world = World(SIMPLE, record_sub_poses=False)
    world.step([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0]])
    policys = np.tile(np.array([-0.5, 0.0, 1.0, 1.0, -1.0], dtype=np.float32), (2, 8, 1))
    guessed = agent.guesses(policys, world.state())
    seen = command_seen(SIMPLE, world.state(), 1)
    assert seen is not None and np.allclose(guessed[:, 0, :3], seen)
    assert np.allclose(guessed[:, 7, :3], policys[:, 7, :3], atol=2 * KEPT**7)
    assert np.array_equal(guessed[..., 3:], policys[..., 3:])


def test_it_needs_the_engine() -> None:
    with pytest.raises(AgentError, match="with the engine, motion; not learned, motion"):
        load_agent("bass@all:partner=motion")
