"""What an agent sees is encoded by the world's own encoder."""

import numpy as np
import pytest

from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import MovingOutError, load_map
from movingout.world import World
from movingout.world.observation import encode_state


def test_an_observation_encodes_its_own_state_and_seat() -> None:
    the_map = load_map("HandOff")
    world = World(the_map)
    world.step([[1.0, 0.3, 0], [0.5, -1.0, 0]])
    observation = observe(the_map, world.state(), seat=1)
    assert observation.tick == 1
    assert np.array_equal(observation.encode("map-v1"), encode_state(the_map, world.state(), 1, "map-v1"))


def test_an_unknown_layout_is_answered_with_the_known_ones() -> None:
    the_map = load_map("HandOff")
    with pytest.raises(MovingOutError, match="official-v1"):
        observe(the_map, start_state(the_map), seat=0).encode("offical")


def test_the_start_state_is_the_worlds_own() -> None:
    the_map = load_map("AdaptiveAssist")
    assert np.array_equal(start_state(the_map).item_poses, World(the_map).state().item_poses)
    assert np.array_equal(start_state(the_map).robot_poses, World(the_map).state().robot_poses)
